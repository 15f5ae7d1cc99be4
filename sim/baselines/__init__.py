"""Other methods that LEXIS is compared with.

The subpackage `rooms` finds rooms in the true map of a house, and holds reduced variants of LEXIS. The subpackage `places`
holds methods of place recognition.
"""
