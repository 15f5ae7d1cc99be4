"""Feature fidelity: what LEXIS would make of images, without images.

`surroundings` → `rays` cast from a pose → `views` (visible share of every thing) → `embedding` (drawn from a model that
`fit` fitted to a real encoder) and `verification` (loops by true covisibility).
"""
