from .fit import fit_features as fit_features
