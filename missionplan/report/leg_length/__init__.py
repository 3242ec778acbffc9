"""Reports of `sweep-dmax` (`sweep`, `sweep_figures`) and of `plan-legs` (`plan`, `plan_figures`)."""
