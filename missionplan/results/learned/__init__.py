"""What measurements taught: `diagnosis` with its `evidence`, the `next_trial` it proposes, and `identification`."""
