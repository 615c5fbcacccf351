// Numbers as texts, digit for digit as the tables of the report have them (codesign/views/report/wording.py).
const makeNumbers = (scales) => {
  // What follows the digits that are kept is exactly a half: Python then rounds to the even digit, a browser away from 0.
  const isTie = (rest) => /^50*$/.test(rest);
  const isEven = (digits) => "02468".includes(digits[digits.length - 1]);

  /** [digits, exponent] of a value above 0, rounded to so many digits. */
  const rounded = (value, digits) => {
    const full = value.toExponential(80).split("e");
    const figures = full[0].replace(".", "");
    if (isTie(figures.slice(digits)) && isEven(figures.slice(0, digits))) return [figures.slice(0, digits), Number(full[1])];
    const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
    return [mantissa.replace(".", ""), Number(exponent)];
  };
  const grouped = (whole) => whole.replace(/\B(?=(\d{3})+$)/g, ",");
  const trimmed = (text) => (text.includes(".") ? text.replace(/\.?0*$/, "") : text);
  const even = (value) => {
    const below = Math.floor(value), rest = value - below;
    return rest < 0.5 || (rest === 0.5 && below % 2 === 0) ? below : below + 1;
  };
  const whole = (value) => grouped(BigInt(Math.abs(even(value))).toString()).replace(/^/, even(value) < 0 ? "-" : "");

  /** As Python's .4g; with commas as its ,.4g. */
  const general = (value, digits, commas = false) => {
    if (value === 0) return Object.is(value, -0) ? "-0" : "0";
    const sign = value < 0 ? "-" : "";
    const [figures, exponent] = rounded(Math.abs(value), digits);
    if (exponent < -4 || exponent >= digits) {
      const power = String(Math.abs(exponent)).padStart(2, "0");
      return `${sign}${trimmed(`${figures[0]}.${figures.slice(1)}`)}e${exponent < 0 ? "-" : "+"}${power}`;
    }
    if (exponent < 0) return `${sign}${trimmed(`0.${"0".repeat(-exponent - 1)}${figures}`)}`;
    const front = figures.slice(0, exponent + 1);
    return sign + trimmed(`${commas ? grouped(front) : front}.${figures.slice(exponent + 1)}`);
  };
  const fixed = (value, digits) => {
    const [front, rest] = Math.abs(value).toFixed(90).split(".");
    const kept = `${front}.${rest.slice(0, digits)}`;
    const text = isTie(rest.slice(digits)) && isEven(kept) ? kept : Math.abs(value).toFixed(digits);
    return (value < 0 || Object.is(value, -0) ? "-" : "") + text;
  };
  const significant = (value) => {
    const text = general(value, 4);
    return text.includes("e") && Math.abs(value) >= 1 ? BigInt(Number(text)).toString() : text;
  };
  const scaled = (value, { base, units }) => {
    if (value === 0) return `0 ${base}`;
    let chosen = units[0];
    for (const unit of units) {
      const [figures, exponent] = rounded(Math.abs(value / unit[1]), 4);
      if (exponent >= 0 && figures[0] !== "0") chosen = unit;
    }
    return `${significant(value / chosen[1])} ${chosen[0]}`;
  };

  const quantity = (value, unit) => {
    if (Number.isNaN(value)) return "nan";
    if (!Number.isFinite(value)) return value > 0 ? "inf" : "-inf";
    if (unit === "s" || unit === "ps") {
      const picoseconds = even(unit === "ps" ? value : value * 1e12);
      return picoseconds ? scaled(picoseconds, scales.s) : "0 s";
    }
    if (unit === "Hz" && value > 0) return scaled(value, scales.Hz);
    if ((unit === "W" || unit === "J") && value >= 0) return scaled(value, scales[unit]);
    const isWhole = (value === even(value) || Math.abs(value) >= 1e4) && Math.abs(value) < 1e15;
    const number = isWhole ? whole(value) : general(value, 4, true);
    if (unit === "" || unit === "1") return number;
    return `${number} ${value === 1 ? unit.replace(/s$/, "") : unit}`;
  };
  const share = (value) => {
    if (value > 0.9999 && value < 1) return ">99.99 %";
    if (value > 0 && value < 0.0001) return "<0.01 %";
    return `${trimmed(fixed(100 * value, 2))} %`;
  };
  /** A value of a figure; NaN: there is none. */
  const text = (value, figure) => {
    if (Number.isNaN(value)) return "–";
    if (figure.counted === "share") return share(value);
    if (figure.counted === "part") return value <= 1 ? share(value) : `${general(100 * value, 4)} %`;
    return quantity(figure.counted === "count" && Number.isFinite(value) ? even(value) : value, figure.unit);
  };
  return { text, quantity, share, count: whole };
};
