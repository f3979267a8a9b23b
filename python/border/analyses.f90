! The border between Fortran and Python: flat subroutines with explicit shapes, from which f2py makes the extension. Here those
! that open and close a box, read a case or results, run an analysis and write a file; fields.f90 has those that carry results.
!
! Every call works on a box (python/box.f90) by its handle; `status` is 0 or the exit status of the error whose message
! the box then holds. Nothing here computes: it calls the library and copies. Complex numbers travel as pairs
! (real, imaginary); `threadsafe` releases Python's global lock, which no call needs, since none calls back.

! A new box; handle 0: there is no memory to begin with.
subroutine open_box(handle)
   use geartrain_base_memory, only: can_begin
   use geartrain_python_box, only: box_type, handle_of
   implicit none
   integer(8), intent(out) :: handle
   type(box_type), pointer :: box

   handle = 0
   if (.not. can_begin()) return
   allocate (box)
   handle = handle_of(box)
end subroutine open_box

! A box with the case and the response of another one, which stays as it is; handle 0: there is no memory for it.
subroutine open_copy(other, handle)
   use geartrain_base_memory, only: can_begin, has_room
   use geartrain_run_results, only: results_bytes
   use geartrain_python_box, only: box_type, box_of, handle_of
   implicit none
   integer(8), intent(in) :: other
   integer(8), intent(out) :: handle
   type(box_type), pointer :: box, from

   handle = 0
   from => box_of(other)
   if (.not. can_begin()) return
   if (allocated(from%results%response)) then
      if (.not. has_room(results_bytes(from%results, from%case))) return
   end if
   allocate (box)
   box%case = from%case
   if (allocated(from%results%response)) box%results%response = from%results%response
   handle = handle_of(box)
end subroutine open_copy

subroutine close_box(handle)
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   type(box_type), pointer :: box

   box => box_of(handle)
   deallocate (box)
end subroutine close_box

! Lets OpenBLAS take kernels for a processor that it does not know.
subroutine blas_kernels()
   use geartrain, only: take_kernels => blas_kernels
   implicit none

   call take_kernels()
end subroutine blas_kernels

! Lets OpenBLAS use so many threads; how many there were, 0 without OpenBLAS.
subroutine blas_threads(number, before)
   use geartrain, only: set_threads => blas_threads
   implicit none
   integer, intent(in) :: number
   integer, intent(out) :: before

   before = set_threads(number)
end subroutine blas_threads

! Reads the case of the box, and its results: `kind` tells what `text` is: 'text' of a case, the path of a 'case' file, or of
! 'results'.
subroutine read_input(handle, kind, text, status)
   use geartrain, only: error_type, read_case, read_case_text, read_results
   use geartrain_python_box, only: box_type, box_of, close_with
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: kind, text
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error

   box => box_of(handle)
   select case (kind)
   case ('text')
      call read_case_text(text, '', box%case, error)
   case ('case')
      call read_case(text, box%case, error)
   case default
      call read_results(text, box%case, box%results, error)
   end select
   status = close_with(box, error)
end subroutine read_input

! Meshes of the case's train, and the size of its states.
subroutine train_sizes(handle, sizes)
   use geartrain_network_network, only: state_count
   use geartrain_python_box, only: box_type, box_of
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(out) :: sizes(2)
   type(box_type), pointer :: box

   box => box_of(handle)
   sizes(1) = size(box%case%train%meshes)
   sizes(2) = state_count(box%case%train)
end subroutine train_sizes

! Runs one analysis that the case asks for, by its name, on from what the box has of it; from the box's first motion, if it has one.
! The branches that follow from it are the box's further ones, after those that it had.
subroutine run_analysis(handle, name, progress, status)
   use geartrain, only: error_type, motion_type
   use geartrain_python_box, only: box_type, box_of, check_memory, close_with
   use geartrain_python_work, only: begin_watch, watch_type
   use geartrain_run_run_case, only: out_of_memory, run => run_analysis
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: name
   double precision, intent(inout), target :: progress(404)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(motion_type), pointer :: start
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   call check_memory(error)
   status = close_with(box, error)
   if (status /= 0) return
   call begin_watch(watch, box, progress)
   nullify (start)
   if (allocated(box%motions)) start => box%motions(1)
   watch%results => box%results
   watch%case => box%case
   watch%measures = .true.
   call watch%forecast%start(resumed=.false.)
   call run(name, box%case, box%results, error, watch, start)
   if (watch%room%lacks .and. .not. allocated(error)) call out_of_memory(error)
   status = close_with(box, error)
end subroutine run_analysis

! Work on the box's branch or on its first motion, see `work` in python/box.f90.
subroutine do_work(handle, what, values, n, progress, status)
   use geartrain, only: error_type
   use geartrain_python_box, only: box_type, box_of, check_memory, close_with
   use geartrain_python_work, only: begin_watch, watch_type, work
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: what
   integer, intent(in) :: n
   double precision, intent(in) :: values(n)
   double precision, intent(inout), target :: progress(404)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   call check_memory(error)
   status = close_with(box, error)
   if (status /= 0) return
   call begin_watch(watch, box, progress)
   call work(box, what, values, watch, error)
   status = close_with(box, error)
end subroutine do_work

! Derivatives with respect to parameters, see `differentiate` in python/box.f90; `show_fields` has them as 'gradient'. The motion is
! given by period, Lambda and coefficients.
subroutine find_gradient(handle, what, names, number, frequency, coefficients, terms, meshes, progress, status)
   use geartrain, only: error_type
   use geartrain_python_box, only: box_type, box_of, check_memory, close_with
   use geartrain_python_work, only: begin_watch, differentiate, watch_type
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: what, names
   integer, intent(in) :: number, terms, meshes
   double precision, intent(in) :: frequency, coefficients(terms, meshes)
   double precision, intent(inout), target :: progress(404)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   call check_memory(error)
   status = close_with(box, error)
   if (status /= 0) return
   call begin_watch(watch, box, progress)
   call differentiate(box, what, names, number, frequency, coefficients, error)
   status = close_with(box, error)
end subroutine find_gradient

! The box's first motion over one of its periods (`periods` 0), or over that many periods of the fundamental; force in N, torque in
! N m.
subroutine sample_waveform(handle, periods, samples, meshes, shafts, progress, time, displacement, velocity, force, torque)
   use geartrain, only: waveform
   use geartrain_python_box, only: box_type, box_of
   use geartrain_python_work, only: begin_watch, watch_type
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: periods, samples, meshes, shafts
   double precision, intent(inout), target :: progress(404)
   double precision, intent(out) :: time(samples), torque(samples, shafts)
   double precision, dimension(samples, meshes), intent(out) :: displacement, velocity, force
   type(box_type), pointer :: box
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   call begin_watch(watch, box, progress)
   if (periods > 0) then
      call waveform(box%case%train, box%motions(1), samples, time, displacement, force, torque, velocity, periods)
   else
      call waveform(box%case%train, box%motions(1), samples, time, displacement, force, torque, velocity)
   end if
end subroutine sample_waveform

! Puts the box's train under torques from outside, at a Lambda, at rest or with the box's first motion; its mean torques [N m], and
! numbers of meshes, shafts, held bodies, and of states.
subroutine begin_simulator(handle, frequency, bodies, torque, sizes, status)
   use geartrain, only: error_type
   use geartrain_python_box, only: box_type, box_of, check_memory, close_with
   implicit none
   integer(8), intent(in) :: handle
   double precision, intent(in) :: frequency
   integer, intent(in) :: bodies
   double precision, intent(out) :: torque(bodies)
   integer, intent(out) :: sizes(4), status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error

   box => box_of(handle)
   torque = 0
   sizes = 0
   call check_memory(error)
   status = close_with(box, error)
   if (status /= 0) return
   if (allocated(box%simulator)) deallocate (box%simulator)
   allocate (box%simulator)
   if (allocated(box%motions)) then
      call box%simulator%begin(box%case%train, frequency, error, box%motions(1))
   else
      call box%simulator%begin(box%case%train, frequency, error)
   end if
   status = close_with(box, error)
   if (status /= 0) return
   associate (system => box%simulator%system, paths => box%simulator%system%torque_paths)
      torque = box%simulator%torque
      sizes = [system%meshes, paths%shafts, paths%held, system%states]
   end associate
end subroutine begin_simulator

! Lets the box's train go on under torques [N m] for a duration [s]; then its time [s], Lambda and phase, speeds of the bodies
! [rad/s], displacements and forces of the meshes, torques of shafts and of what holds bodies, state.
subroutine advance_simulator(handle, torque, bodies, duration, progress, meshes, rows, states, now, speed, displacement, force, &
                             shaft_torque, state, status)
   use geartrain, only: error_type
   use geartrain_python_box, only: box_type, box_of, close_with
   use geartrain_python_work, only: begin_watch, watch_type
   implicit none
   integer(8), intent(in) :: handle
   integer, intent(in) :: bodies, meshes, rows, states
   double precision, intent(in) :: torque(bodies), duration
   double precision, intent(inout), target :: progress(404)
   double precision, intent(out) :: now(3), speed(bodies), displacement(meshes), force(meshes), shaft_torque(rows), state(states)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   call begin_watch(watch, box, progress)
   associate (simulator => box%simulator)
      simulator%system%interrupt = box%case%train%interrupt
      call simulator%advance(torque, duration, error)
      now = [simulator%time, simulator%frequency_ratio, simulator%phase]
      state = simulator%state()
      if (.not. allocated(error)) call simulator%look(speed, displacement, force, shaft_torque)
   end associate
   status = close_with(box, error)
end subroutine advance_simulator

! Everything that the case asks for; `path` is where the results go, '' nowhere; `checkpoint` the file to go on from, '' none.
subroutine run_all(handle, path, checkpoint, progress, status)
   use geartrain, only: error_type, run_case
   use geartrain_python_box, only: box_type, box_of, check_memory, close_with
   use geartrain_python_work, only: begin_watch, watch_type
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: path, checkpoint
   double precision, intent(inout), target :: progress(404)
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error
   type(watch_type) :: watch
   !f2py threadsafe

   box => box_of(handle)
   call check_memory(error)
   status = close_with(box, error)
   if (status /= 0) return
   call begin_watch(watch, box, progress)
   watch%results => box%results
   watch%case => box%case
   call watch%forecast%start(resumed=checkpoint /= '')
   call run_case(box%case, path, box%results, error, watch, checkpoint)
   status = close_with(box, error)
end subroutine run_all

! Writes the box's results.
subroutine write_path(handle, path, status)
   use geartrain, only: error_type, locate_edges, write_results
   use geartrain_python_box, only: box_type, box_of, close_with
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: path
   integer, intent(out) :: status
   type(box_type), pointer :: box
   type(error_type), allocatable :: error

   box => box_of(handle)
   call locate_edges(box%case, box%results)
   call write_results(path, box%case, box%results, error)
   status = close_with(box, error)
end subroutine write_path

! Replaces a file by bytes, or makes one.
subroutine write_bytes(handle, path, bytes, content, status)
   use geartrain, only: error_type
   use geartrain_python_box, only: box_type, box_of, close_with
   use geartrain_results_file, only: replace_file
   implicit none
   integer(8), intent(in) :: handle
   character(*), intent(in) :: path
   integer, intent(in) :: bytes
   integer(1), intent(in) :: content(bytes)
   integer, intent(out) :: status
   type(error_type), allocatable :: error

   call replace_file(path, content, error)
   status = close_with(box_of(handle), error)
end subroutine write_bytes
