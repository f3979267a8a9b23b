!> Whether results read back are those of a case: every count agrees with the arrays that it counts and with the train, before
!> anything of them is used.
module geartrain_results_agreement
   use geartrain_branch_branch, only: branch_type, trace_state_type
   use geartrain_branch_path, only: place_type
   use geartrain_branch_stability_map_settings, only: map_row_type, stability_map_settings_type, stability_map_type
   use geartrain_case_case, only: case_type
   use geartrain_model_network, only: coordinate_count
   use geartrain_motion_attractors_settings, only: attractors_type
   use geartrain_motion_integration_settings, only: integration_settings_type, sweep_type
   use geartrain_motion_motion, only: motion_type
   use geartrain_results_results, only: results_type
   implicit none (type, external)
   private
   public :: disagreement

contains

   !> Which part of the results does not agree with itself or with the case, in a word; blank where all does.
   function disagreement(case, results) result(part)
      type(case_type), intent(in) :: case
      type(results_type), intent(in) :: results
      character(16) :: part
      integer :: elements, i
      logical :: asked

      part = ''
      elements = coordinate_count(case%train)
      asked = allocated(case%response)
      associate (meshes => size(case%train%meshes))
         if (allocated(results%response)) then
            if (asked) asked = branch_agrees(results%response, meshes, elements)
            if (.not. asked) part = 'response'
         end if
         if (allocated(results%branches)) then
            do i = 1, size(results%branches)
               if (.not. branch_agrees(results%branches(i), meshes, elements)) part = 'branches'
            end do
         end if
         if (allocated(results%integration)) then
            if (.not. allocated(case%integration)) then
               part = 'integration'
            else if (.not. sweep_agrees(results%integration, case%integration, meshes, elements)) then
               part = 'integration'
            end if
         end if
         if (allocated(results%attractors)) then
            if (.not. allocated(case%attractors)) then
               part = 'attractors'
            else if (.not. attractors_agree(results%attractors, case%attractors%starts, meshes, elements)) then
               part = 'attractors'
            end if
         end if
         if (allocated(results%stability_map)) then
            if (.not. allocated(case%stability_map)) then
               part = 'stability map'
            else if (.not. map_agrees(results%stability_map, case%stability_map, meshes)) then
               part = 'stability map'
            end if
         end if
      end associate
   end function disagreement

   !> A branch, be it one of which only the origin is known so far.
   pure logical function branch_agrees(branch, meshes, elements) result(agrees)
      type(branch_type), intent(in) :: branch
      !> Of the train.
      integer, intent(in) :: meshes, elements
      integer :: i

      agrees = branch%points >= 0 .and. branch%subharmonic >= 1
      if (.not. allocated(branch%frequency)) then
         agrees = agrees .and. branch%points == 0
         return
      end if
      associate (n => branch%points)
         agrees = agrees .and. branch%meshes == meshes .and. branch%harmonics >= 1 .and. branch%states <= 2*elements .and. &
                  allocated(branch%coefficients) .and. allocated(branch%rms) .and. allocated(branch%mean) .and. &
                  allocated(branch%minimum) .and. allocated(branch%maximum) .and. allocated(branch%backlash) .and. &
                  allocated(branch%mesh_load) .and. allocated(branch%error_estimate) .and. &
                  allocated(branch%estimate_doubtful) .and. allocated(branch%point_harmonics) .and. allocated(branch%part) .and. &
                  allocated(branch%special_points)
         if (.not. agrees) return
         agrees = size(branch%frequency) == n .and. all(shape(branch%coefficients) == [1 + 2*branch%harmonics, meshes, n]) .and. &
                  all(shape(branch%rms) == [meshes, n]) .and. all(shape(branch%mean) == [meshes, n]) .and. &
                  all(shape(branch%minimum) == [meshes, n]) .and. all(shape(branch%maximum) == [meshes, n]) .and. &
                  size(branch%backlash) == meshes .and. all(shape(branch%mesh_load) == [meshes, n]) .and. &
                  size(branch%error_estimate) == n .and. size(branch%estimate_doubtful) == n .and. &
                  size(branch%point_harmonics) == n .and. size(branch%part) == n
         if (agrees) agrees = all(branch%point_harmonics <= branch%harmonics) .and. all(branch%part >= 1)
         if (allocated(branch%stable)) then
            agrees = agrees .and. allocated(branch%multipliers) .and. allocated(branch%undecided) .and. &
                     allocated(branch%second_estimate) .and. allocated(branch%count_undecided)
            if (.not. agrees) return
            agrees = size(branch%stable) == n .and. all(shape(branch%multipliers) == [branch%states, n]) .and. &
                     size(branch%undecided) == n .and. size(branch%second_estimate) == n .and. &
                     size(branch%count_undecided) == n
         end if
         if (allocated(branch%correction)) agrees = agrees .and. size(branch%correction) == n
         do i = 1, size(branch%special_points)
            associate (special => branch%special_points(i))
               agrees = agrees .and. special%point >= 0 .and. special%point <= n .and. allocated(special%rms)
               if (agrees) agrees = size(special%rms) == meshes
            end associate
         end do
      end associate
      if (agrees .and. allocated(branch%trace)) agrees = trace_agrees(branch%trace, branch%points, meshes)
   end function branch_agrees

   !> Where a trace stands: its points are among the `points` of the branch, its places have as many meshes as are unknown.
   pure logical function trace_agrees(trace, points, meshes) result(agrees)
      type(trace_state_type), intent(in) :: trace
      integer, intent(in) :: points, meshes

      agrees = trace%first_points >= 0 .and. trace%first_points <= points .and. trace%steps >= 0 .and. trace%missed >= 0
      if (.not. agrees .or. trace%steps == 0) return
      agrees = trace%harmonics >= 1 .and. trace%step > 0 .and. place_agrees(trace%here, trace%harmonics, meshes) .and. &
               place_agrees(trace%origin, trace%harmonics, meshes)
   end function trace_agrees

   !> A solved place of harmonics up to `highest`.
   pure logical function place_agrees(place, highest, meshes) result(agrees)
      type(place_type), intent(in) :: place
      integer, intent(in) :: highest, meshes

      agrees = allocated(place%u) .and. allocated(place%tangent) .and. allocated(place%harmonic) .and. place%frequency > 0
      if (.not. agrees) return
      agrees = size(place%u, 1) == 1 + 2*size(place%harmonic) .and. size(place%u, 2) <= meshes .and. &
               all(shape(place%tangent) == shape(place%u)) .and. all(place%harmonic >= 1) .and. all(place%harmonic <= highest)
   end function place_agrees

   !> Of a sweep every frequency has its room.
   pure logical function sweep_agrees(sweep, settings, meshes, elements) result(agrees)
      type(sweep_type), intent(in) :: sweep
      type(integration_settings_type), intent(in) :: settings
      integer, intent(in) :: meshes, elements
      integer :: i, total

      agrees = allocated(sweep%motions) .eqv. allocated(sweep%direction)
      if (.not. agrees) return
      if (.not. allocated(sweep%motions)) then
         agrees = .not. allocated(sweep%ended)
         return
      end if
      total = merge(2*settings%points, settings%points, settings%direction == 'both')
      agrees = size(sweep%motions) == total .and. size(sweep%direction) == total
      if (sweep%complete) agrees = agrees .and. all(sweep%motions%frequency > 0)
      do i = 1, size(sweep%motions)
         if (sweep%motions(i)%frequency > 0) agrees = agrees .and. motion_agrees(sweep%motions(i), meshes, elements)
      end do
   end function sweep_agrees

   !> A search that is done or under way has motions, be they none.
   pure logical function attractors_agree(found, starts, meshes, elements) result(agrees)
      type(attractors_type), intent(in) :: found
      !> As asked for.
      integer, intent(in) :: starts
      integer, intent(in) :: meshes, elements
      integer :: i

      agrees = found%starts >= 0 .and. found%starts <= starts
      if (.not. allocated(found%motions)) then
         agrees = agrees .and. found%starts == 0 .and. .not. allocated(found%ended)
         return
      end if
      if (found%complete) agrees = agrees .and. found%starts == starts
      do i = 1, size(found%motions)
         agrees = agrees .and. found%motions(i)%period >= 1 .and. motion_agrees(found%motions(i), meshes, elements)
      end do
   end function attractors_agree

   !> A motion that integration gave; one that ran away has a state alone.
   pure logical function motion_agrees(motion, meshes, elements) result(agrees)
      type(motion_type), intent(in) :: motion
      integer, intent(in) :: meshes, elements

      agrees = motion%frequency > 0 .and. motion%period >= 0 .and. allocated(motion%state)
      if (agrees) agrees = size(motion%state) == 2*elements
      if (.not. agrees .or. .not. allocated(motion%coefficients)) return
      agrees = allocated(motion%rms) .and. allocated(motion%mean) .and. allocated(motion%minimum) .and. &
               allocated(motion%maximum) .and. allocated(motion%mesh_load)
      if (agrees) agrees = size(motion%coefficients, 2) == meshes .and. mod(size(motion%coefficients, 1), 2) == 1 .and. &
                           all([size(motion%rms), size(motion%mean), size(motion%minimum), size(motion%maximum), &
                                size(motion%mesh_load)] == meshes)
      if (agrees .and. allocated(motion%multipliers)) agrees = size(motion%multipliers) == 2*elements
   end function motion_agrees

   !> A map has the grid that was asked for, under way row by row.
   pure logical function map_agrees(map, settings, meshes) result(agrees)
      type(stability_map_type), intent(in) :: map
      type(stability_map_settings_type), intent(in) :: settings
      integer, intent(in) :: meshes
      integer :: i

      if (.not. allocated(map%done)) then
         agrees = .not. (allocated(map%ended) .or. allocated(map%rows))
         return
      end if
      agrees = allocated(map%name) .and. allocated(map%unit) .and. allocated(map%frequency) .and. allocated(map%parameter) .and. &
               allocated(map%whole) .and. (map%linear .eqv. settings%linear) .and. &
               (allocated(map%rows) .neqv. allocated(map%ended))
      if (.not. agrees) return
      associate (points => settings%points, rows => settings%parameter_points)
         agrees = size(map%frequency) == points .and. size(map%parameter) == rows .and. size(map%done) == rows .and. &
                  size(map%whole) == rows
         if (allocated(map%rows)) then
            agrees = agrees .and. size(map%rows) == rows
            if (.not. agrees) return
            do i = 1, rows
               if (map%done(i)) agrees = agrees .and. row_agrees(map%rows(i), points, meshes, settings%linear)
            end do
            return
         end if
         agrees = agrees .and. allocated(map%motions) .and. allocated(map%stable_motions) .and. allocated(map%multiplier) .and. &
                  (allocated(map%rms) .neqv. settings%linear)
         if (.not. agrees) return
         agrees = all(shape(map%motions) == [points, rows]) .and. all(shape(map%stable_motions) == [points, rows]) .and. &
                  all(shape(map%multiplier) == [points, rows])
         if (agrees .and. allocated(map%rms)) agrees = all(shape(map%rms) == [meshes, points, rows])
      end associate
   end function map_agrees

   pure logical function row_agrees(row, points, meshes, linear) result(agrees)
      type(map_row_type), intent(in) :: row
      integer, intent(in) :: points, meshes
      logical, intent(in) :: linear

      agrees = allocated(row%motions) .and. allocated(row%stable_motions) .and. allocated(row%multiplier) .and. &
               (allocated(row%rms) .neqv. linear)
      if (.not. agrees) return
      agrees = size(row%motions) == points .and. size(row%stable_motions) == points .and. size(row%multiplier) == points
      if (agrees .and. .not. linear) agrees = all(shape(row%rms) == [meshes, points])
   end function row_agrees

end module geartrain_results_agreement
