"""Laws: what something costs, each written once and over any numbers.

A law is asked with whole numbers by the simulation, with arrays of many machines by pricing, and with symbols by
verdicts. Terms, price keys, directions and levers follow from what it answers to symbols.
"""

from codesign.laws.links import BusLaw, IdealLaw, LinkLaw, SerialLaw
from codesign.laws.monomial import Monomial
from codesign.laws.numbers import Sum, as_sum, ceil_div, symbol

__all__ = ["BusLaw", "IdealLaw", "LinkLaw", "Monomial", "SerialLaw", "Sum", "as_sum", "ceil_div", "symbol"]
