"""How good and how fast it is: benchmarks and evaluations. Only the command line uses them."""
