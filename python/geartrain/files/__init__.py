"""Files of other programs: what is read into a train, and what motions are written to."""
