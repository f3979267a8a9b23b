!> The fields of an audit: the group /audit, which Python takes; no results file has it.
module geartrain_exact_audit_fields
   use geartrain_base_carry, only: carry
   use geartrain_base_field, only: row => field_type
   use geartrain_base_fields, only: fields_type
   use geartrain_base_kinds, only: dp
   use geartrain_exact_audit_result, only: audit_row_type, audit_type
   implicit none (type, external)
   private
   public :: visit_audit

contains

   !> Visits the group of an audit.
   subroutine visit_audit(audit, fields)
      !> The audit.
      type(audit_type), intent(inout) :: audit
      !> The fields of the results.
      class(fields_type), intent(inout) :: fields
      integer :: i, n

      if (.not. fields%enter('/audit', 'points and special points of a branch solved anew by shooting', .true.)) return
      call carry(fields, row('points', '', '', 'points audited'), audit%points)
      call carry(fields, row('as_estimated', '', '', 'points whose error is as estimated'), audit%as_estimated)
      call carry(fields, row('doubtful', '', '', 'other points, whose estimate is called doubtful'), audit%doubtful)
      call carry(fields, row('special_points', '', '', 'special points audited'), audit%special_points)
      call carry(fields, row('confirmed', '', '', 'special points of which nothing is wrong'), audit%confirmed)
      call carry(fields, row('wrong_verdicts', '', '', 'of points and special points'), audit%wrong_verdicts)
      call carry(fields, row('ok', '', '', '1: nothing is wrong'), audit%ok)
      n = size(audit%rows)
      call fields%index_axis('row', n, 'points, then special points, in the order of the branch')
      call fields%begin_list('row')
      do i = 1, n
         call fields%visit_item(i)
         call visit_row(audit%rows(i), fields)
      end do
      call fields%end_list()
   end subroutine visit_audit

   subroutine visit_row(audited, fields)
      type(audit_row_type), intent(inout) :: audited
      class(fields_type), intent(inout) :: fields
      real(dp) :: ratio

      ratio = audited%ratio()
      call carry(fields, row('kind', '', '', 'point, or the kind of the special point'), audited%kind)
      call carry(fields, row('frequency', '', '1', 'Lambda as the branch has it'), audited%frequency_ratio)
      call carry(fields, row('exact_frequency', '', '1', 'Lambda of the special point of the exact branch', &
                             none_is_negative=.true.), audited%exact_frequency)
      call carry(fields, row('point', '', '1', 'the point; of a special point the one before it'), audited%point)
      call carry(fields, row('error_estimate', '', '1', 'relative error of the waveform as estimated', none_is_negative=.true.), &
                 audited%estimate)
      call carry(fields, row('error', '', '1', 'relative error of the waveform as found', none_is_negative=.true.), audited%error)
      call carry(fields, row('ratio', '', '1', 'error over its estimate', none_is_negative=.true.), ratio)
      call carry(fields, row('estimate_doubtful', '', '1', '1 = the branch says so'), audited%doubtful)
      call carry(fields, row('estimate_wrong', '', '1', '1 = the error is not as estimated'), audited%estimate_wrong)
      call carry(fields, row('verdict_wrong', '', '1', '1 = the verdicts contradict each other'), audited%verdict_wrong)
      call carry(fields, row('verdict', '', '', 'stability as the branch has it'), audited%verdict)
      call carry(fields, row('exact_verdict', '', '', 'stability by shooting'), audited%exact_verdict)
      call carry(fields, row('finding', '', '', 'what is wrong or worth knowing, in words'), audited%finding)
   end subroutine visit_row

end module geartrain_exact_audit_fields
