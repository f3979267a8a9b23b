!> The ways to give a mesh stiffness against one another: a table, a contact ratio, a phase, and harmonics as such.
module unit_mesh
   use fixtures, only: paper_train, settings_of
   use geartrain, only: branch_type, case_type, dp, error_type, integrate, integration_settings_type, mesh_type, motion_type, &
                        read_case_text, response, train_type
   use geartrain_base_kinds, only: pi
   use geartrain_train_mesh, only: plain_mesh
   use testing, only: tests_type
   implicit none (type, external)
   private
   public :: mesh_tests

contains

   subroutine mesh_tests(tests)
      class(tests_type), intent(inout) :: tests

      if (tests%runs('table')) call table(tests)
      if (tests%runs('contact_ratio')) call contact_ratio(tests)
      if (tests%runs('phase')) call phase(tests)
      if (tests%runs('refused')) call refused(tests)
   end subroutine mesh_tests

   !> The polynomial goes through the values, of even and of odd number, and one of the paper's kappa gives the paper's train.
   subroutine table(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train
      type(branch_type) :: as_table, as_harmonics
      type(error_type), allocatable :: error
      integer :: j

      call interpolates([1.0_dp, 3.0_dp, 2.0_dp, 5.0_dp, 4.0_dp, 4.5_dp])
      call interpolates([1.0_dp, 3.0_dp, 2.0_dp, 5.0_dp, 4.0_dp])
      train = paper_train()
      call response(train, settings_of(0.85_dp, 0.95_dp, 6), as_harmonics, error)
      do j = 1, 2
         train%meshes(j)%stiffness_table = train%meshes(j)%stiffness*[1.3_dp, 1.0_dp, 0.7_dp, 1.0_dp]
         train%meshes(j)%stiffness = 0
         deallocate (train%meshes(j)%stiffness_cos)
      end do
      call response(train, settings_of(0.85_dp, 0.95_dp, 6), as_table, error)
      call tests%is_true(.not. allocated(error), 'a table of kappa = 1 + 0.3 cos runs')
      if (allocated(error)) return
      call tests%is_close(maxval(abs(as_table%rms(:, 1) - as_harmonics%rms(:, 1))), 0.0_dp, 1e-12_dp, 'and gives its rms')

   contains

      subroutine interpolates(values)
         real(dp), intent(in) :: values(:)
         type(mesh_type) :: mesh, plain
         real(dp) :: theta, k
         integer :: h, i

         mesh%stiffness_table = values
         plain = mesh
         call plain_mesh(plain)
         call tests%is_close(plain%stiffness, sum(values)/size(values), 1e-14_dp, 'mean of a table')
         do i = 1, size(values)
            theta = 2*pi*(i - 1)/size(values)
            k = 1
            do h = 1, size(plain%stiffness_cos)
               k = k + plain%stiffness_cos(h)*cos(h*theta) + plain%stiffness_sin(h)*sin(h*theta)
            end do
            call tests%is_close(k*plain%stiffness, values(i), 1e-13_dp, 'a table is met')
         end do
      end subroutine interpolates

   end subroutine table

   !> Against the integral over the rectangular wave that has one tooth pair in contact all the time and another for a share of 0.6
   !> of the cycle, centred at 0.
   subroutine contact_ratio(tests)
      class(tests_type), intent(inout) :: tests
      type(mesh_type) :: mesh, plain
      integer, parameter :: cells = 200000
      real(dp) :: theta, wave, sums(3)
      integer :: h, i

      mesh%stiffness = 1e8_dp
      mesh%contact_ratio = 1.6_dp
      mesh%stiffness_harmonics = 3
      plain = mesh
      call plain_mesh(plain)
      call tests%is_true(size(plain%stiffness_cos) == 3, 'as many harmonics as asked for')
      sums = 0
      do i = 1, cells
         theta = 2*pi*(i - 0.5_dp)/cells
         wave = 1
         if (cos(theta) > cos(0.6_dp*pi)) wave = 2
         sums = sums + [(2*wave*cos(h*theta)/(1.6_dp*cells), h=1, 3)]
      end do
      call tests%is_close(maxval(abs(plain%stiffness_cos - sums)), 0.0_dp, 1e-5_dp, 'harmonics of the rectangular wave')
      ! The table of the paper's figure 8: contact ratio 1.5.
      mesh%contact_ratio = 1.5_dp
      mesh%stiffness_harmonics = 5
      plain = mesh
      call plain_mesh(plain)
      call tests%is_close(maxval(abs(plain%stiffness_cos - [0.424_dp, 0.0_dp, -0.141_dp, 0.0_dp, 0.085_dp])), 0.0_dp, 1e-3_dp, &
                          'contact ratio 1.5')
      ! Above 2 the time with the extra pair is centred at half the cycle, above 3 at its beginning again.
      do i = 2, 3
         mesh%contact_ratio = i + 0.4_dp
         mesh%stiffness_harmonics = 3
         plain = mesh
         call plain_mesh(plain)
         sums = 0
         do h = 1, cells
            theta = 2*pi*(h - 0.5_dp)/cells
            wave = i
            if (merge(-1, 1, i == 2)*cos(theta) > cos(0.4_dp*pi)) wave = i + 1
            sums = sums + 2*wave*[cos(theta), cos(2*theta), cos(3*theta)]/(mesh%contact_ratio*cells)
         end do
         call tests%is_close(maxval(abs(plain%stiffness_cos - sums)), 0.0_dp, 1e-5_dp, 'extra pair of a larger contact ratio')
      end do
   end subroutine contact_ratio

   !> All meshes with one phase move later; a phase of one alone is that of its kappa and its error.
   subroutine phase(tests)
      class(tests_type), intent(inout) :: tests
      type(train_type) :: train, later
      type(motion_type) :: a, b
      type(error_type), allocatable :: error
      integer :: j

      train = paper_train()
      do j = 1, 2
         train%meshes(j)%error_sin = [2e-6_dp, 1e-6_dp]
         train%meshes(j)%stiffness_sin = [0.05_dp, 0.02_dp]
      end do
      later = train
      later%meshes%phase = 0.8_dp
      call integrate(train, 0.9_dp, integration_settings_type(), a, error)
      call integrate(later, 0.9_dp, integration_settings_type(), b, error)
      call tests%is_true(.not. allocated(error), 'a phase runs')
      if (allocated(error)) return
      call tests%is_close(maxval(abs(a%rms - b%rms)), 0.0_dp, 1e-9_dp, 'phase of all meshes: rms')
      do j = 1, 2
         call tests%is_close(b%coefficients(2, j), a%coefficients(2, j)*cos(0.8_dp) - a%coefficients(3, j)*sin(0.8_dp), 1e-8_dp, &
                             'phase of all meshes: later')
      end do
      later = train
      later%meshes(2)%phase = pi/2
      train%meshes(2)%stiffness_cos = [-0.05_dp, -0.0_dp]
      train%meshes(2)%stiffness_sin = [0.3_dp, -0.02_dp]
      train%meshes(2)%error_cos = [-2e-6_dp, 0.0_dp]
      train%meshes(2)%error_sin = [0.0_dp, -1e-6_dp]
      call integrate(train, 0.9_dp, integration_settings_type(), a, error)
      call integrate(later, 0.9_dp, integration_settings_type(), b, error)
      call tests%is_close(maxval(abs(a%coefficients - b%coefficients)), 0.0_dp, 1e-8_dp, 'a quarter of a cycle')
   end subroutine phase

   !> Two ways at once, or too short a table.
   subroutine refused(tests)
      class(tests_type), intent(inout) :: tests
      character(*), parameter :: n = new_line('a')
      character(*), parameter :: head = '&train input_torque = 100.0, prime_mover_inertia = 1e-3, load_inertia = 1e-3, &
         &characteristic_length = 1e-5, characteristic_frequency = 1e4 /'//n//'&shaft stiffness = 1e4 /'//n// &
         '&mesh driving_radius = 0.05, driven_radius = 0.1, driving_inertia = 1e-3, driven_inertia = 1e-3,'//n
      character(*), parameter :: tail = ' /'//n//'&shaft stiffness = 1e4 /'//n//'&modes /'//n

      call told('stiffness = 1e8, contact_ratio = 1.5', '')
      call told('stiffness_table = 1e8, 2e8, 1e8, 2e8', '')
      call told('stiffness_cos = 0.3', 'x.nml:3:1: error: &mesh 1: lacks stiffness (> 0 N/m) or &
                &stiffness_table, or teeth, normal_module and face_width')
      call told('stiffness_table = 1e8, 2e8, 1e8', 'x.nml:4:19: error: &mesh 1: stiffness_table = 3 values: must be at least 4')
      call told('stiffness = 1e8, stiffness_table = 1e8, 2e8, 1e8, 2e8', &
                'x.nml:4:13: error: &mesh 1: stiffness = 1.0e8: contradicts stiffness_table: leave out one of the two')
      call told('stiffness = 1e8, contact_ratio = 1.5, stiffness_cos = 0.3', 'x.nml:4:34: error: &mesh 1: contact_ratio = 1.5: &
                &contradicts stiffness_cos, stiffness_sin: leave out one of the two')
      call told('stiffness = 1e8, contact_ratio = 0.9', 'x.nml:4:34: error: &mesh 1: contact_ratio = 0.9: must be > 1 and <= 10')

   contains

      subroutine told(given, message)
         character(*), intent(in) :: given, message
         type(case_type) :: case
         type(error_type), allocatable :: error

         call read_case_text(head//given//tail, 'x.nml', case, error)
         if (.not. allocated(error)) then
            call tests%is_text('', message, 'stiffness: '//given)
         else
            call tests%is_text(error%message(:index(error%message//n, n) - 1), message, 'stiffness: '//given)
         end if
      end subroutine told

   end subroutine refused

end module unit_mesh
