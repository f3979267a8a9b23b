!> The size of the states of a train.
module geartrain_model_state_count
   use geartrain_model_bodies, only: body_count
   use geartrain_model_drawing, only: plain_train
   use geartrain_model_network, only: build_network, network_type
   use geartrain_model_train, only: train_type
   implicit none (type, external)
   private
   public :: state_count

contains

   !> Number of values of a state: displacements and velocities of the coordinates. 0 for a train without bodies.
   pure integer function state_count(train)
      !> The train as given; its shafts are allocated.
      type(train_type), intent(in) :: train
      type(train_type) :: plain
      type(network_type) :: network

      state_count = 0
      if (body_count(train) == 0) return
      ! Loops of gears need the radii.
      call plain_train(train, plain)
      call build_network(plain, network)
      state_count = network%displacements + network%coordinates
   end function state_count

end module geartrain_model_state_count
