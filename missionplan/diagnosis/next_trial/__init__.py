"""The trial worth making next: `next_trial` values `designs` and instruments by what they would save (`losses`)."""
