"""What the analyses give: branches, motions, maps, and their tables."""
