"""The guide's own tools: pages of reference written from the code, drawings, signatures of effects, figures kept current."""
