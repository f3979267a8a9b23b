!> The fields of contact onsets and of an exact special point, which Python takes; no results file has them.
module geartrain_exact_exact_fields
   use geartrain_base_carry, only: carry
   use geartrain_base_field, only: row => field_type
   use geartrain_base_fields, only: fields_type
   use geartrain_exact_exact_point, only: exact_point_type
   use geartrain_flow_motion_fields, only: about_rms
   use geartrain_trace_branch, only: branch_type, special_point_type
   use geartrain_trace_free_fields, only: carry_free
   implicit none (type, external)
   private
   public :: visit_exact_point, visit_onsets

contains

   !> Visits the group of the contact onsets of a branch.
   subroutine visit_onsets(branch, onsets, fields)
      !> The branch.
      type(branch_type), intent(in) :: branch
      !> The onsets.
      type(special_point_type), intent(inout) :: onsets(:)
      !> The fields of the results.
      class(fields_type), intent(inout) :: fields
      logical, allocatable :: interpolated(:)
      integer :: i, n

      if (.not. fields%enter('/onsets', 'contact onsets of a branch', .true.)) return
      n = size(onsets)
      call fields%index_axis('onset', n, 'in the order along the branch')
      allocate (interpolated(n))
      if (n > 0) interpolated = branch%contact_edges%interpolated
      call fields%begin_list('onset')
      do i = 1, n
         call fields%visit_item(i)
         call carry(fields, row('kind', '', '', 'separation, back contact, stage N reached'), onsets(i)%kind)
         call carry(fields, row('mesh', '', '1', 'the mesh'), onsets(i)%mesh)
         call carry_free(branch, fields, onsets(i)%frequency_ratio)
         call carry(fields, row('after_point', '', '1', 'point of the branch before the onset'), onsets(i)%point)
         call carry(fields, row('rms', 'mesh', '1', about_rms), onsets(i)%rms)
         call carry(fields, row('undecided', '', '1', '1 = interpolated between points of the branch'), interpolated(i))
      end do
      call fields%end_list()
   end subroutine visit_onsets

   !> Visits the group of an exact special point; its motion is visited elsewhere.
   subroutine visit_exact_point(exact, fields)
      !> The special point.
      type(exact_point_type), intent(inout) :: exact
      !> The fields of the results.
      class(fields_type), intent(inout) :: fields

      if (.not. fields%enter('/exact', 'a special point of the exact motion', .true.)) return
      call carry(fields, row('kind', '', '', 'as of a special point'), exact%kind)
      call carry(fields, row('mesh', '', '1', 'of a contact onset the mesh, else 0'), exact%mesh)
      call carry(fields, row('multiplicity', '', '1', 'as of a special point'), exact%multiplicity)
      call carry(fields, row('frequency', '', '1', 'Lambda'), exact%frequency_ratio)
      call carry(fields, row('before', '', '1', 'multipliers outside the unit circle before it, -1: not known'), exact%before)
      call carry(fields, row('after', '', '1', 'multipliers outside the unit circle after it, -1: not known'), exact%after)
      call carry(fields, row('criticality', '', '', 'of a period doubling or a Neimark-Sacker point supercritical or &
                     &subcritical; blank: not known'), exact%criticality)
      call carry(fields, row('slowest_event', '', '1', 'smallest mesh speed at a contact event; huge: no event'), &
                 exact%slowest_event)
   end subroutine visit_exact_point

end module geartrain_exact_exact_fields
