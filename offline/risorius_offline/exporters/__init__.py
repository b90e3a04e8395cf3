"""Writers of formats of other programs, one a file."""
