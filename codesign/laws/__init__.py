"""Laws: what something costs, each written once and over any numbers.

A law is asked with whole numbers by the simulation, with arrays of many machines by pricing, and with symbols by
verdicts. Terms, price keys, directions and levers follow from what it answers to symbols.
"""

from codesign.laws.acts import Law
from codesign.laws.numbers import Monomial, Number, Sum, as_sum, ceil_div, symbol

__all__ = ["Law", "Monomial", "Number", "Sum", "as_sum", "ceil_div", "symbol"]
