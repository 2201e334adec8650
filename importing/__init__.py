"""Recordings of any robot brought in: bags and tables of any rate become one drive. No model, no estimate."""
