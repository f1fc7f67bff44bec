"""What the fields are called, what they are measured in, and what their columns mean."""

import numpy as np

LABEL_FIELDS = {"region", "rank", "part"}  # whole numbers that only name something
TITLES = {"determinant_F": "det F", "von_mises": "von Mises stress", "cauchy_stress": "Cauchy stress",
          "first_piola": "first Piola-Kirchhoff stress", "green_lagrange": "Green-Lagrange strain",
          "reaction": "reaction force"}
QUANTITIES = {"displacement": "length", "von_mises": "stress", "cauchy_stress": "stress",
              "first_piola": "stress", "principal_stresses": "stress", "energy_density": "stress",
              "reaction": "force", "determinant_F": "1", "principal_stretches": "1",
              "green_lagrange": "1", "velocity": "length/s", "acceleration": "length/s²"}
NINE = ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"]
SIX = ["xx", "xy", "xz", "yy", "yz", "zz"]  # XDMF's Tensor6
FOUR = ["xx", "xy", "yx", "yy"]


def title(name):
    return TITLES.get(name, name.replace("_", " "))


class Units:
    """Units by quantity; the program itself has none, so that all are empty unless two are named."""

    def __init__(self, text=None):
        self.length, self.force = (None, None)
        if text:
            words = text.replace(",", " ").split()
            if len(words) != 2:
                raise ValueError(f"units are a length and a force, such as 'mm, N', not '{text}'")
            self.length, self.force = words

    def of(self, quantity):
        """The unit of length, area, volume, force, moment, stress, energy; "" where unknown."""
        if quantity == "1" or not self.length:
            return ""
        length, force = self.length, self.force
        known = {("m", "N", "stress"): "Pa", ("mm", "N", "stress"): "MPa", ("m", "N", "energy"): "J",
                 ("mm", "N", "energy"): "mJ", ("m", "kN", "energy"): "kJ", ("m", "kN", "stress"): "kPa"}
        return known.get((length, force, quantity)) or {
            "length": length, "area": length + "²", "volume": length + "³", "force": force,
            "moment": f"{force} {length}", "stress": f"{force}/{length}²",
            "energy": f"{force} {length}", "length/s": f"{length}/s",
            "length/s²": f"{length}/s²"}.get(quantity, "")


def unit(name, units):
    return units.of(QUANTITIES.get(name, ""))


def columns(name, values):
    """A field's columns by name; vectors and tensors also have a magnitude, which comes first."""
    if values.ndim == 1:
        return {"": values}
    values = values.reshape(len(values), -1)
    count = values.shape[1]
    if count == 1:
        return {"": values[:, 0]}
    if name.startswith("principal"):
        return {str(k + 1): values[:, k] for k in range(count)}
    names = {2: ["x", "y"], 3: ["x", "y", "z"], 4: FOUR, 6: SIX, 9: NINE}.get(
        count, [str(k + 1) for k in range(count)])
    twice = np.array([1, 2, 2, 1, 2, 1]) if count == 6 else 1  # what stands above the diagonal
    return {"magnitude": np.sqrt((twice * values ** 2).sum(axis=1)),
            **{each: values[:, k] for k, each in enumerate(names)}}
