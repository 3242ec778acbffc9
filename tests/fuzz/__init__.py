"""Damaged and hostile input: ``python -m tests.fuzz`` changes the shipped examples at random and sees what breaks.

Read `examples` (what is changed), `mutations` (how), `targets` (what is done with it), `attempts` (what counts as a
finding). A finding is kept in `cases/` and run by `test_fuzz` ever after.
"""
