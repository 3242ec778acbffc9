"""The package's public functions: found when first used, and hidden by no subpackage."""

import pkgutil

import missionplan


def test_every_public_name_can_be_used_again_and_again():
    for name in missionplan.__all__:
        assert getattr(missionplan, name) is getattr(missionplan, name)
    functions = [getattr(missionplan, name) for name in missionplan.__all__ if not name.startswith("_")]
    assert all(callable(function) for function in functions)


def test_no_subpackage_has_the_name_of_a_command():
    subpackages = {module.name for module in pkgutil.iter_modules(missionplan.__path__)}
    commands = {"compare", "explore", "export", "history", "init", "optimise", "score", "tide", "validate"}
    assert subpackages.isdisjoint({*missionplan.__all__, *commands})
