"""What the tool computes, measured against closed forms, papers, peer programs, made-up data and the sea.

``python -m validation`` measures every cheap row again and writes `docs/validation`; see `validation.__main__`.
"""
