"""What commands show: tables and sentences as wide as the terminal, 80 columns in a pipe."""
