"""The trial worth making next: `valuation` of `designs` and `instruments` by what they would save (`losses`)."""
