"""What a mission file may hold, section by section, in SI once validated. Read first `mission`."""
