!> What excites a train at an order of the fundamental: meshes by their harmonics, torques by bodies.
module geartrain_report_sources
   use geartrain_base_kinds, only: dp
   use geartrain_base_numbers, only: text
   use geartrain_base_series, only: make_series, series_type
   use geartrain_drawing_drawing, only: plain_train
   use geartrain_network_system, only: build_system, system_type
   use geartrain_train_bodies, only: body_count, find_ends
   use geartrain_train_body, only: has_table_of_torque
   use geartrain_train_kinematics, only: find_kinematics, kinematics_type
   use geartrain_train_labels, only: body_labels, label_length
   use geartrain_train_names, only: list_numbers
   use geartrain_train_train, only: train_type
   implicit none (type, external)
   private
   public :: sources_type, find_sources

   !> Amplitude below which a series does not excite, over the largest of the series [1].
   real(dp), parameter :: least = 1e-9_dp

   !> Largest sum of the multiples of two mesh frequencies that name an order.
   integer, parameter :: most_times = 5
   !> Largest multiple of a mesh frequency that is named beside an error of a gear of the same order.
   integer, parameter :: most_multiple = 8

   type :: sources_type
      private
      !> Order of the fundamental of each mesh; of the torque of each body, its revolution where it has a torque of that, (body).
      integer, allocatable :: mesh_order(:), body_order(:)
      !> Variation of the stiffness and transmission error, (mesh); torques, (torque), and their bodies.
      type(series_type), allocatable :: variation(:), transmission_error(:), torque(:)
      integer, allocatable :: torque_body(:)
      !> Revolutions of a body in the cycle of its torque, (body).
      integer, allocatable :: revolutions(:)
      !> Errors of the gears of each mesh, (gear, mesh), and the bodies that these are.
      type(series_type), allocatable :: gear_error(:, :)
      integer, allocatable :: gear_body(:, :), gear_order(:, :)
      !> Names of the bodies.
      character(label_length), allocatable :: bodies(:)
   contains
      procedure :: name
   end type sources_type

contains

   !> Lists what excites a train.
   subroutine find_sources(train, sources)
      !> A train that has passed `check_train`.
      type(train_type), intent(in) :: train
      !> The sources.
      type(sources_type), intent(out) :: sources
      type(system_type) :: system
      type(train_type) :: plain
      type(kinematics_type) :: kinematics
      integer, allocatable :: shaft_ends(:, :)
      integer :: gear, j

      call plain_train(train, plain)
      call build_system(train, system)
      call find_kinematics(train, kinematics)
      sources%mesh_order = merge(plain%meshes%order, 0, plain%meshes%is_pair() .and. .not. plain%meshes%locked)
      allocate (sources%body_order(body_count(train)), source=0)
      if (kinematics%known) sources%body_order = kinematics%revolution_order
      allocate (sources%revolutions(size(sources%body_order)), source=1)
      if (allocated(train%bodies)) &
         where (has_table_of_torque(train%bodies)) sources%revolutions = train%bodies%torque_revolutions
      call find_ends(train, shaft_ends, sources%gear_body)
      allocate (sources%gear_error(2, system%meshes), sources%gear_order(2, system%meshes))
      do j = 1, system%meshes
         do gear = 1, 2
            associate (error => plain%meshes(j)%gear_error(gear))
               sources%gear_error(gear, j) = make_series(error%cosine, error%sine, 1.0_dp, error%order)
               sources%gear_order(gear, j) = error%order
            end associate
         end do
      end do
      sources%torque = system%torque
      sources%torque_body = system%torque_body
      sources%transmission_error = system%transmission_error
      allocate (sources%variation(system%meshes))
      do j = 1, system%meshes
         sources%variation(j) = system%law(j)%variation()
      end do
      sources%bodies = body_labels(train)
   end subroutine find_sources

   !> What excites at an order: 'mesh 1', '2 x meshes 1, 2', '2 x revolution of engine'. Where nothing, or only some error of a
   !> gear, has this order itself, the meshes whose tooth frequency is a divisor of it, as '2 x mesh 1 (indirectly)': by varying
   !> stiffness or loss of contact.
   subroutine name(self, order, words)
      class(sources_type), intent(in) :: self
      !> Order of the fundamental, of a motion of a longer period a fraction [1].
      real(dp), intent(in) :: order
      !> The words.
      character(:), allocatable, intent(out) :: words
      logical :: is_there(size(self%mesh_order))
      character(:), allocatable :: gears
      integer :: whole, multiple, j, pass

      whole = nint(order)
      words = ''
      gears = ''
      if (abs(order - whole) > 1e-9_dp*order) then
         words = 'subharmonic'
         return
      end if
      do pass = 1, 2
         if (pass == 2 .and. words /= '') exit
         do multiple = 1, merge(whole, min(whole, most_multiple), gears == '')
            if (mod(whole, multiple) /= 0) cycle
            do j = 1, size(is_there)
               is_there(j) = self%mesh_order(j)*multiple == whole
               if (is_there(j) .and. pass == 1) is_there(j) = excites(self%variation(j), whole) .or. &
                                                              excites(self%transmission_error(j), whole)
            end do
            if (any(is_there)) call add_meshes(multiple, is_there, words)
         end do
         if (pass == 1) call add_torques(self, whole, words)
         if (pass == 1) call add_gears(self, whole, gears)
         if (pass == 2 .and. words /= '') words = words//' (indirectly)'
      end do
      call join(words, gears)
      if (words == '') call find_combination(self, whole, words)
      if (words == '') call find_sideband(self, whole, words)
      if (words == '') words = 'no single source'
   end subroutine name

   !> Adds to a list of words.
   pure subroutine join(words, more)
      character(:), allocatable, intent(inout) :: words
      character(*), intent(in) :: more

      if (words /= '' .and. more /= '') words = words//'; '
      words = words//more
   end subroutine join

   !> Adds meshes at one multiple of their tooth frequencies.
   subroutine add_meshes(multiple, is_there, words)
      integer, intent(in) :: multiple
      logical, intent(in) :: is_there(:)
      character(:), allocatable, intent(inout) :: words
      character(:), allocatable :: list

      call list_numbers(is_there, 'mesh', 'meshes', list)
      if (multiple > 1) list = text(multiple)//' x '//list
      call join(words, list)
   end subroutine add_meshes

   !> Adds the torques on bodies.
   subroutine add_torques(self, order, words)
      class(sources_type), intent(in) :: self
      integer, intent(in) :: order
      character(:), allocatable, intent(inout) :: words
      integer :: i, n

      do i = 1, size(self%torque)
         if (.not. excites(self%torque(i), order)) cycle
         if (words /= '') words = words//'; '
         associate (body => self%torque_body(i))
            n = order
            if (self%body_order(body) > 0) n = order/self%body_order(body)
            if (n /= self%revolutions(body)) words = words//text(real(n, dp)/self%revolutions(body))//' x '
            if (self%body_order(body) > 0) then
               words = words//'revolution of '//trim(self%bodies(body))
            else
               words = words//'torque on '//trim(self%bodies(body))
            end if
         end associate
      end do
   end subroutine add_torques

   !> Adds the gears with errors.
   subroutine add_gears(self, order, words)
      class(sources_type), intent(in) :: self
      integer, intent(in) :: order
      character(:), allocatable, intent(inout) :: words
      character(:), allocatable :: one
      integer :: gear, j

      do j = 1, size(self%gear_error, 2)
         do gear = 1, 2
            if (.not. excites(self%gear_error(gear, j), order)) cycle
            call turns_of(self, gear, j, order, one)
            if (index('; '//words//';', '; '//one//';') == 0) call join(words, one)
         end do
      end do
   end subroutine add_gears

   !> A multiple of the revolution of a gear: '3 x revolution of pinion'.
   subroutine turns_of(self, gear, mesh, order, words)
      class(sources_type), intent(in) :: self
      integer, intent(in) :: gear, mesh
      !> Of the fundamental.
      integer, intent(in) :: order
      character(:), allocatable, intent(out) :: words

      words = 'revolution of '//trim(self%bodies(self%gear_body(gear, mesh)))
      if (order /= self%gear_order(gear, mesh)) words = text(real(order/self%gear_order(gear, mesh), dp))//' x '//words
   end subroutine turns_of

   !> The simplest sum or difference of multiples of two mesh frequencies that an order is: '2 x mesh 1 - mesh 2'; '' where there is
   !> none.
   subroutine find_combination(self, order, words)
      class(sources_type), intent(in) :: self
      integer, intent(in) :: order
      character(:), allocatable, intent(inout) :: words
      integer :: i, j, left, times, others, total

      do total = 2, most_times
         do i = 1, size(self%mesh_order)
            do j = 1, size(self%mesh_order)
               if (min(self%mesh_order(i), self%mesh_order(j)) < 1) cycle
               if (most_times*real(max(self%mesh_order(i), self%mesh_order(j)), dp) > huge(1)) cycle
               do times = 1, total - 1
                  others = total - times
                  left = order - times*self%mesh_order(i)
                  if (abs(left) /= others*self%mesh_order(j) .or. (left > 0 .and. i > j)) cycle
                  words = 'mesh '//text(j)
                  if (others > 1) words = text(others)//' x '//words
                  words = 'mesh '//text(i)//trim(merge(' +', ' -', left > 0))//' '//words
                  if (times > 1) words = text(times)//' x '//words
                  return
               end do
            end do
         end do
      end do
   end subroutine find_combination

   !> The nearest multiple of a mesh frequency whose gear has errors, of which an order is a sideband: '2 x mesh 1 - revolution of
   !> pinion'; '' where there is none.
   subroutine find_sideband(self, order, words)
      class(sources_type), intent(in) :: self
      integer, intent(in) :: order
      character(:), allocatable, intent(inout) :: words
      character(:), allocatable :: one
      integer :: distance, gear, j, multiple, nearest

      nearest = huge(1)
      do j = 1, size(self%gear_error, 2)
         do gear = 1, 2
            if (size(self%gear_error(gear, j)%harmonic) == 0) cycle
            multiple = max(1, nint(real(order, dp)/self%mesh_order(j)))
            distance = order - multiple*self%mesh_order(j)
            if (mod(distance, self%gear_order(gear, j)) /= 0) cycle
            if (abs(distance/self%gear_order(gear, j)) >= nearest) cycle
            nearest = abs(distance/self%gear_order(gear, j))
            call turns_of(self, gear, j, abs(distance), one)
            words = 'mesh '//text(j)//trim(merge(' +', ' -', distance > 0))//' '//one
            if (multiple > 1) words = text(multiple)//' x '//words
         end do
      end do
   end subroutine find_sideband

   !> Whether a series has an amplitude at a harmonic of the fundamental.
   pure logical function excites(series, order)
      type(series_type), intent(in) :: series
      integer, intent(in) :: order
      integer :: h

      excites = .false.
      if (.not. allocated(series%harmonic)) return
      do h = 1, size(series%harmonic)
         if (series%harmonic(h) == order) excites = abs(series%amplitude(h)) > least*maxval(abs(series%amplitude))
      end do
   end function excites

end module geartrain_report_sources
