"""What only the reference simulator does: its search for the wheel, its idler arm, its joints. Off unless a run asks for it."""
