"""Judges that benchmarks and tests share: what is held against what, and how the difference is measured."""
