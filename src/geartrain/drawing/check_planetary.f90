!> Checks of a planetary set: it can be made and assembled. Meshes that cannot be made are told of the expanded train.
module geartrain_drawing_check_planetary
   use geartrain_base_checker, only: checker_type
   use geartrain_base_kinds, only: dp, pi
   use geartrain_base_nearest, only: nearest_name
   use geartrain_base_numbers, only: integer_text, real_text, text, whole
   use geartrain_base_sorting, only: ascending
   use geartrain_drawing_gear_pair, only: involute
   use geartrain_drawing_planetary_meshes, only: planet_name, set_type
   use geartrain_train_body, only: name_length
   use geartrain_train_mesh, only: is_given
   use geartrain_train_planetary, only: planetary_type
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: check_rows, check_set

   !> Difference of the centre distances of sun meshes and ring meshes that is rounding of a drawing, over the module; distance of
   !> an angle from one at which a planet can be assembled, in steps of 1/(z_s + z_r) turns [1].
   real(dp), parameter :: rounding = 1e-3_dp, step_rounding = 1e-2_dp
   !> Difference of two angles that is rounding of given decimals [turns].
   real(dp), parameter :: same_angle = 1e-4_dp
   !> Profile shift that gears are hardly made with [1].
   real(dp), parameter :: most_shift = 2

contains

   !> Adds every problem of a planetary set.
   subroutine check_set(sets, index, numbers, train, checker)
      !> All sets of the train as given, with any values.
      type(planetary_type), intent(in) :: sets(:)
      !> Number of the set.
      integer, intent(in) :: index
      !> Numbers of the set.
      type(set_type), intent(in) :: numbers
      !> The train, with its bodies; earlier sets are expanded.
      type(train_type), intent(in) :: train
      class(checker_type), intent(inout) :: checker
      integer :: before

      before = checker%problems%count
      call checker%enter('planetary', index)
      if (allocated(train%bodies)) then
         call check_names(sets, index, numbers, train, checker)
      else
         call checker%problems%add('needs &body groups, which sun, ring and carrier name', 'planetary', index)
      end if
      associate (set => sets(index))
         call check_lists(set, numbers, checker)
         if (checker%problems%count == before .and. .not. checker%problems%in_group('planetary')) then
            call check_axes(set, numbers, checker)
            call check_assembly(set, numbers, checker)
            call check_room(set, numbers, checker)
         end if
      end associate
      call checker%leave()
   end subroutine check_set

   !> Planets that shafts join with planets of another set, as stepped planets, stand at the angles of those.
   subroutine check_rows(sets, index, numbers, train, checker)
      !> All sets of the train as given; those so far are in order.
      type(planetary_type), intent(in) :: sets(:)
      !> Number of the set.
      integer, intent(in) :: index
      !> Numbers of the set.
      type(set_type), intent(in) :: numbers
      !> The train, with its shafts.
      type(train_type), intent(in) :: train
      class(checker_type), intent(inout) :: checker
      type(set_type) :: others
      integer, allocatable :: pairs(:, :)
      integer :: other

      do other = 1, index - 1
         if (sets(other)%carrier /= sets(index)%carrier) cycle
         call others%setup(sets(other))
         call find_joined(sets(index), numbers%planets, sets(other), others%planets, train, pairs)
         if (size(pairs, 2) < 2) cycle
         associate (own => numbers%turn(pairs(1, :)) - numbers%turn(pairs(1, 1)), &
                    its => others%turn(pairs(2, :)) - others%turn(pairs(2, 1)))
            ! The planets turn as one, so the suns of both turn in one sense, in which the angles count.
            if (all(abs(own - its - anint(own - its)) < same_angle)) cycle
         end associate
         call checker%enter('planetary', index)
         call checker%complain(trim(merge('angles ', 'planets', is_given(sets(index)%angles))), '...', "must put the planets at &
            &the places of the planets of '"//trim(sets(other)%name)//"', with which shafts join them")
         call checker%leave()
      end do
   end subroutine check_rows

   !> Planets of two sets that shafts join.
   pure subroutine find_joined(one, planets, other, others, train, pairs)
      type(planetary_type), intent(in) :: one, other
      !> Numbers of planets of both.
      integer, intent(in) :: planets, others
      type(train_type), intent(in) :: train
      !> Numbers of planets that are joined, (2, pair).
      integer, allocatable, intent(out) :: pairs(:, :)
      integer :: i, k, m, found(2, size(train%shafts)), n

      n = 0
      do i = 1, size(train%shafts)
         do k = 1, 2
            m = findloc([(planet_name(one, m) == train%shafts(i)%between(k), m=1, planets)], .true., 1)
            if (m == 0) cycle
            found(:, n + 1) = [m, findloc([(planet_name(other, m) == train%shafts(i)%between(3 - k), m=1, others)], .true., 1)]
            if (found(2, n + 1) > 0) n = n + 1
            exit
         end do
      end do
      pairs = found(:, :n)
   end subroutine find_joined

   !> The set has a name of its own, and names bodies.
   subroutine check_names(sets, index, numbers, train, checker)
      type(planetary_type), intent(in) :: sets(:)
      integer, intent(in) :: index
      type(set_type), intent(in) :: numbers
      type(train_type), intent(in) :: train
      class(checker_type), intent(inout) :: checker
      character(name_length) :: names(size(train%bodies))
      integer :: i, n

      names = ''
      do i = 1, size(names)
         if (allocated(train%bodies(i)%name)) names(i) = train%bodies(i)%name
      end do
      associate (set => sets(index))
         if (.not. allocated(set%name)) then
            call checker%lacks('name', '')
         else if (set%name == '') then
            call checker%lacks('name', '')
         else if (len_trim(set%name) + len(' planet '//integer_text(numbers%planets)) > name_length) then
            call checker%complain('name', "'"//set%name//"'", 'must be shorter: a name of a body has at most '// &
                                  integer_text(name_length)//' bytes')
         else
            if (any(names == set%name)) call checker%complain('name', "'"//set%name//"'", 'is that of a &body already')
            do i = 1, index - 1
               if (.not. allocated(sets(i)%name)) cycle
               if (sets(i)%name == set%name) call checker%complain('name', "'"//set%name//"'", 'is that of &planetary '// &
                                                                   integer_text(i)//' already')
            end do
            do n = 1, numbers%planets
               if (.not. any(names == planet_name(set, n))) cycle
               call checker%complain('name', "'"//set%name//"'", "makes a planet of the name '"//trim(planet_name(set, n))// &
                                     "', which is that of a &body already")
               exit
            end do
         end if
         if (set%carrier == '') call checker%lacks('carrier', 'the name of a body')
         if (.not. any(numbers%has)) call checker%lacks('sun', 'the name of a body', ' or ring')
         call check_body('sun', set%sun)
         call check_body('ring', set%ring)
         call check_body('carrier', set%carrier)
         if (all(numbers%has) .and. set%sun == set%ring) call twice('ring', set%ring, 'sun')
         if (numbers%has(1) .and. set%carrier == set%sun) call twice('carrier', set%carrier, 'sun')
         if (numbers%has(2) .and. set%carrier == set%ring) call twice('carrier', set%carrier, 'ring')
      end associate

   contains

      subroutine check_body(variable, name)
         character(*), intent(in) :: variable, name
         integer :: best

         if (name == '' .or. any(names == name)) return
         if (any(checker%problems%reported('body', [(i, i=1, size(names))], 'name'))) return
         best = nearest_name(trim(name), names)
         if (best > 0) then
            call checker%complain(variable, "'"//trim(name)//"'", "is the name of no &body (did you mean '"// &
                                  trim(names(best))//"'?)")
         else
            call checker%complain(variable, "'"//trim(name)//"'", 'is the name of no &body')
         end if
      end subroutine check_body

      subroutine twice(variable, name, other)
         character(*), intent(in) :: variable, name, other

         call checker%complain(variable, "'"//trim(name)//"'", 'is the '//other//' as well: must be another body')
      end subroutine twice

   end subroutine check_names

   !> Lists have the numbers of values that they must have, and what belongs together is given.
   subroutine check_lists(set, numbers, checker)
      type(planetary_type), intent(in) :: set
      type(set_type), intent(in) :: numbers
      class(checker_type), intent(inout) :: checker
      character(*), parameter :: member(3) = [character(6) :: 'sun', 'planet', 'ring']
      logical :: has(3)
      integer :: i, worst

      has = [numbers%has(1), .true., numbers%has(2)]
      if (.not. is_given(set%teeth)) then
         call checker%lacks('teeth', 'numbers of teeth of sun, planet and ring')
      else if (size(set%teeth) == 3) then
         do i = 1, 3
            if (has(i) .and. set%teeth(i) < 3) then
               call checker%complain('teeth', integer_text(whole(set%teeth(i))), 'must be >= 3 of the '//trim(member(i)), i)
            else if (.not. has(i) .and. set%teeth(i) > 0) then
               call checker%complain('teeth', integer_text(whole(set%teeth(i))), 'is of a '//trim(member(i))//', whose body is not &
                                     &named: give `'//trim(member(i))//'`, or 0 teeth', i)
            end if
         end do
         if (has(3) .and. set%teeth(3) <= set%teeth(2)) &
            call checker%complain('teeth', integer_text(whole(set%teeth(3))), 'must be > '//integer_text(whole(set%teeth(2)))// &
                                  ', the teeth of a planet: the ring is smaller than its planets', 3)
      end if
      if (is_given(set%angles) .and. set%planets > 0) then
         call checker%complain('angles', integer_text(size(set%angles))//' values', 'contradict planets: leave out one of the two')
      else if (is_given(set%angles)) then
         if (size(set%angles) < 2) call checker%complain('angles', '1 value', 'must be at least 2')
      else if (set%planets < 2) then
         call checker%lacks('planets', '>= 2', ' or angles')
      end if
      if (is_given(set%planet_errors)) then
         if (size(set%planet_errors) /= numbers%planets .and. numbers%planets > 0) &
            call checker%complain('planet_errors', integer_text(size(set%planet_errors))//' values', 'must be '// &
                                  integer_text(numbers%planets)//' values, one a planet')
         worst = maxloc(abs(set%planet_errors), 1)
         if (set%normal_module > 0 .and. abs(set%planet_errors(worst)) >= set%normal_module) &
            call checker%complain('planet_errors', real_text(set%planet_errors(worst)), 'must be smaller than the module, '// &
                                  real_text(set%normal_module)//' m: a micrometre is 1e-6', worst)
      end if
      call check_pair('backlash', set%backlash)
      call check_pair('half_backlash', set%half_backlash)
      call check_pair('stiffness', set%stiffness)
      call check_pair('damping_ratio', set%damping_ratio)
      call check_pair('damping', set%damping)
      call check_pair('loss_factor', set%loss_factor)
      call check_pair('contact_ratio', set%contact_ratio)
      if (is_given(set%damping) .and. is_given(set%damping_ratio)) &
         call checker%complain('damping', real_text(set%damping(1)), 'is given together with damping_ratio: leave out one of the &
                               &two')
      if (set%planet_inertia < 0 .and. .not. set%face_width > 0) &
         call checker%lacks('planet_inertia', '> 0 kg m^2', ' or face_width, of a disc')
      if (set%planet_bore > 0 .and. .not. set%face_width > 0) &
         call checker%lacks('face_width', '> 0 m', ', to which planet_bore belongs')
      if (.not. set%face_width > 0 .and. .not. is_given(set%stiffness)) &
         call checker%lacks('stiffness', '> 0 N/m', ' or face_width')
      if (set%ring_face_width > 0 .and. .not. set%face_width > 0) &
         call checker%lacks('face_width', '> 0 m', ', beside ring_face_width')
      if (set%ring_phase_given .and. .not. all(numbers%has)) &
         call checker%complain('ring_phase', real_text(set%ring_phase), 'is between sun meshes and ring meshes: the set lacks one &
                               &kind')
      call check_kind(1, 'sun', is_given(set%sun_stiffness_cos) .or. is_given(set%sun_stiffness_sin) .or. &
                      is_given(set%sun_error_cos) .or. is_given(set%sun_error_sin))
      call check_kind(2, 'ring', is_given(set%ring_stiffness_cos) .or. is_given(set%ring_stiffness_sin) .or. &
                      is_given(set%ring_error_cos) .or. is_given(set%ring_error_sin))

   contains

      subroutine check_pair(name, list)
         character(*), intent(in) :: name
         real(dp), allocatable, intent(in) :: list(:)

         if (.not. is_given(list)) return
         if (size(list) > 2) call checker%complain(name, integer_text(size(list))//' values', &
                                                   'must be 2 values, of sun meshes and ring meshes, or one of both')
      end subroutine check_pair

      subroutine check_kind(kind, word, used)
         integer, intent(in) :: kind
         character(*), intent(in) :: word
         logical, intent(in) :: used

         if (used .and. .not. numbers%has(kind)) &
            call checker%lacks(word, 'the name of a body', ', to whose meshes stiffness and error of the '//word//' belong')
      end subroutine check_kind

   end subroutine check_lists

   !> Sun, planets and ring fit on one axis: the meshes with the sun and with the ring have one centre distance.
   subroutine check_axes(set, numbers, checker)
      type(planetary_type), intent(in) :: set
      type(set_type), intent(in) :: numbers
      class(checker_type), intent(inout) :: checker
      character(:), allocatable :: words
      real(dp) :: cosine, sum_2, shift(3)

      if (.not. all(numbers%drawn) .or. set%centre_distance > 0) return
      associate (one => numbers%geometry(1), two => numbers%geometry(2), z => set%teeth)
         if (.not. (one%working_angle > 0 .and. two%working_angle > 0)) return
         if (abs(one%tight_distance - two%tight_distance) <= rounding*set%normal_module) return
         words = 'do not fit on one axis: without backlash the centre distance is '//text(one%tight_distance)//' m of sun and &
                 &planet, '//text(two%tight_distance)//' m of planet and ring'
         if (z(3) > z(2) .and. abs(z(3) - z(1) - 2*z(2)) > 0 .and. .not. is_given(set%profile_shift)) &
            words = words//'; a ring of '//integer_text(whole(z(1) + 2*z(2)))//' teeth would fit'
         shift = 0
         if (is_given(set%profile_shift)) shift = set%profile_shift
         cosine = two%reference_distance*cos(two%transverse_angle)/one%tight_distance
         if (cosine < 1) then
            sum_2 = (involute(acos(cosine)) - involute(two%transverse_angle))*(z(2) - z(3))/(2*tan(set%pressure_angle*pi/180))
            if (abs(sum_2 - shift(2)) < most_shift) words = words//'; profile_shift = '//text(shift(1))//', '// &
                                                            text(shift(2))//', '//text(sum_2 - shift(2))//' would fit'
         end if
         if (one%tight_distance < two%tight_distance) words = words//'; a centre_distance in between makes backlash'
         call checker%complain('teeth', integer_text(whole(z(1)))//', '//integer_text(whole(z(2)))//', '// &
                              integer_text(whole(z(3))), words)
      end associate
   end subroutine check_axes

   !> Every planet meets teeth of sun and ring where it is.
   subroutine check_assembly(set, numbers, checker)
      type(planetary_type), intent(in) :: set
      type(set_type), intent(in) :: numbers
      class(checker_type), intent(inout) :: checker
      character(:), allocatable :: words
      real(dp) :: steps
      integer :: sum_z, n

      if (.not. all(numbers%drawn)) return
      sum_z = whole(set%teeth(1) + set%teeth(3))
      if (is_given(set%angles)) then
         do n = 2, numbers%planets
            steps = numbers%turn(n)*sum_z
            if (abs(steps - anint(steps)) <= step_rounding) cycle
            call checker%complain('angles', real_text(set%angles(n)), 'cannot be assembled: from the first planet it must be a &
               &multiple of 360/(z_sun + z_ring) = '//text(360.0_dp/sum_z)//' degree, the nearest is '// &
               text(set%angles(1) + 360*anint(steps)/sum_z), n)
            return
         end do
      else if (modulo(sum_z, numbers%planets) /= 0) then
         words = ''
         do n = 1, min(numbers%planets, 12)
            if (n > 1) words = words//', '
            words = words//text(360*anint((n - 1)*real(sum_z, dp)/numbers%planets)/sum_z)
         end do
         if (numbers%planets > 12) words = words//', ...'
         call checker%complain('planets', integer_text(numbers%planets), 'cannot be equally spaced: (z_sun + z_ring)/planets = '// &
            integer_text(sum_z)//'/'//integer_text(numbers%planets)//' is not whole; the nearest that can be assembled are &
            &angles = '//words)
      end if
   end subroutine check_assembly

   !> Neighbouring planets do not touch.
   subroutine check_room(set, numbers, checker)
      type(planetary_type), intent(in) :: set
      type(set_type), intent(in) :: numbers
      class(checker_type), intent(inout) :: checker
      real(dp) :: place(numbers%planets), distance
      integer :: n

      if (.not. any(numbers%drawn)) return
      place = modulo(numbers%turn, 1.0_dp)
      place = place(ascending(place))
      associate (gap => [(place(n + 1) - place(n), n=1, size(place) - 1), place(1) + 1 - place(size(place))])
         distance = 2*numbers%centre_distance*sin(pi*min(minval(gap), 0.5_dp))
      end associate
      if (distance > numbers%planet_tip) return
      if (is_given(set%angles)) then
         call checker%complain('angles', integer_text(numbers%planets)//' values', trim(overlap()))
      else
         call checker%complain('planets', integer_text(numbers%planets), trim(overlap()))
      end if

   contains

      function overlap() result(words)
         character(200) :: words

         words = 'overlap: the tip diameter of '//text(numbers%planet_tip)//' m must be smaller than the distance of &
                 &neighbouring axes, '//text(distance)//' m'
      end function overlap

   end subroutine check_room

end module geartrain_drawing_check_planetary
