"""What the tool computes, measured against closed forms, papers, peer programs, made-up data and the sea.

``python -m validation`` measures every cheap row again and writes `validation/measured`; see `validation.__main__`.
"""
