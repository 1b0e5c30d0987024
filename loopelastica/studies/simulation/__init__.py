"""Whether a simulation accepts the models: OpenMM's force fields on models and natives."""
