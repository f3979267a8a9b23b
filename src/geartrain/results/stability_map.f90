!> The group /stability_map of a results file: stability over Lambda and one parameter.
module geartrain_results_stability_map
   use geartrain_branch_stability_map_settings, only: stability_map_type
   use geartrain_results_labels, only: as_parts, frequency_description
   use geartrain_results_store, only: store_type
   implicit none (type, external)
   private
   public :: write_stability_map

   character(*), parameter :: home = '/stability_map'
   character(9), parameter :: grid(2) = ['parameter', 'frequency']

contains

   !> Writes the rows so far; `ended` may still be unknown.
   subroutine write_stability_map(store, map)
      type(store_type), intent(inout) :: store
      type(stability_map_type), intent(in) :: map
      type(stability_map_type) :: part

      call store%group(home)
      call store%attribute(home, 'description', 'stability over frequency and one parameter of the train')
      if (allocated(map%ended)) then
         call store%attribute(home, 'ended', map%ended)
      else
         call store%attribute(home, 'ended', 'not yet: these are the rows so far')
      end if
      call store%attribute(home, 'complete', merge(1, 0, map%complete))
      if (allocated(map%rows)) then
         part = map
         call part%gather()
         call write_grid(store, part)
      else if (allocated(map%parameter)) then
         call write_grid(store, map)
      end if
   end subroutine write_stability_map

   subroutine write_grid(store, map)
      type(store_type), intent(inout) :: store
      type(stability_map_type), intent(in) :: map

      call store%attribute(home, 'parameter_name', map%name)
      call store%attribute(home, 'linear', merge(1, 0, map%linear))
      call store%axis(home//'/parameter', map%parameter, map%unit, map%name)
      call store%axis(home//'/frequency', map%frequency, '1', frequency_description)
      call store%put(home//'/row_done', map%done, ['parameter'], '1 = the row is computed; rows that are not are left out')
      call store%put(home//'/row_whole', map%whole, ['parameter'], '1 = the branch of the row got through the range; 0 = not: &
                     &motions may be missing')
      call store%put(home//'/motions', map%motions, grid, '1', 'motions of the mesh period on the branch')
      call store%put(home//'/stable_motions', map%stable_motions, grid, '1', 'how many of them are stable; 0: the train does &
                     &something else, of a longer period or of none')
      call store%put(home//'/spectral_radius', abs(map%multiplier), grid, '1', 'largest magnitude of a Floquet multiplier over a &
                     &mesh period, of the motion that has it smallest; NaN: no motion')
      call store%axis(home//'/complex', ['real     ', 'imaginary'], 'part of a complex number')
      call store%put(home//'/multiplier', as_parts(map%multiplier), [grid, 'complex  '], '1', &
                     'that multiplier: near +1 a fold or a resonance at a natural frequency, near -1 a doubling of the period')
      if (.not. allocated(map%rms)) return
      call store%axis(home//'/mesh', size(map%rms, 1), 'mesh, in the order of the train')
      call store%put(home//'/rms', map%rms, ['parameter', 'frequency', 'mesh     '], '1', 'largest rms of the stable motions / &
                     &characteristic_length, the rms of /response; NaN: no stable motion')
   end subroutine write_grid

end module geartrain_results_stability_map
