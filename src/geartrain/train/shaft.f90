!> A torsional shaft in SI units.
module geartrain_train_shaft
   use geartrain_base_kinds, only: dp
   use geartrain_train_body, only: name_length
   implicit none (type, external)
   private
   public :: shaft_type

   type :: shaft_type
      !> Names of the two bodies that the shaft joins; blank in a chain.
      character(name_length) :: between(2) = ''
      !> Torsional stiffness [N m/rad]; not used when rigid.
      real(dp) :: stiffness = 0
      !> From the drawing: diameters, bores and lengths of the sections in series [m], one bore holds for all; shear modulus
      !> [N/m^2].
      real(dp), allocatable :: diameter(:), bore(:), length(:)
      real(dp) :: shear_modulus = 8e10_dp
      !> Damping ratio [1], c/(2 sqrt(k m_eq)), m_eq = 1/(1/I_a + 1/I_b); or `damping`, whichever is given.
      real(dp) :: damping_ratio = 0
      !> Damping coefficient [N m s/rad], in force when `damping_given`.
      real(dp) :: damping = 0
      logical :: damping_given = .false.
      !> Loss factor [1], in place of both; 0: not given.
      real(dp) :: loss_factor = 0
      !> The bodies at both ends move as one.
      logical :: rigid = .false.
   end type shaft_type

end module geartrain_train_shaft
