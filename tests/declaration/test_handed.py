"""A model where a declaration is expected, and the other way round, is refused by name with what to hand over."""

import pytest

import softsoil
from drives import MULTI_LOG, clay_bicycle, reference_vehicle
from softsoil.symbolic.soil import CLAY


@pytest.mark.parametrize("name", ["estimate", "predict", "map_soil", "late_clocks"])
def test_a_declaration_is_no_model(name):
    declared = softsoil.Declaration(reference_vehicle(), CLAY)
    logs = [MULTI_LOG] if name == "map_soil" else MULTI_LOG
    more = (None,) if name == "late_clocks" else ()
    with pytest.raises(TypeError, match=rf"{name}: expected a model, found a Declaration: hand over its build\(\)"):
        getattr(softsoil, name)(logs, declared, *more)


def test_a_soil_is_no_model():
    with pytest.raises(TypeError, match=r"Ocp: expected a model, found a Soil: hand over softsoil\.bicycle"):
        softsoil.Ocp(CLAY, reference_vehicle())


@pytest.mark.parametrize("name", ["refine", "residual", "generate"])
def test_a_model_is_no_declaration(name, tmp_path):
    first = {"refine": ([MULTI_LOG],), "residual": (MULTI_LOG,), "generate": ()}[name]
    more = (tmp_path,) if name == "generate" else ()
    with pytest.raises(TypeError, match=rf"{name}: expected a declaration, found a Model: hand over softsoil\.Declaration"):
        getattr(softsoil, name)(*first, clay_bicycle(), *more)
    assert not list(tmp_path.iterdir())
