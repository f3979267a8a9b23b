"""What can be asked of a train."""
