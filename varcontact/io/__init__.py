"""Files: scenes from TOML, solutions to and from netCDF."""
