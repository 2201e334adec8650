"""A CasADi model of a wheeled vehicle on deformable soil, from one declaration to everything that needs it."""
