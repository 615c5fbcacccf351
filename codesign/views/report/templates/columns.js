// Columns of numbers: the page holds them deflated, as typed arrays behind one another (codesign/views/report/columns.py).
const readColumns = async (packed) => {
  const letters = atob(packed.trim());
  const deflated = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i += 1) deflated[i] = letters.charCodeAt(i);
  const stream = new Blob([deflated]).stream().pipeThrough(new DecompressionStream("deflate"));
  const buffer = await new Response(stream).arrayBuffer();
  const bytes = new Uint8Array(buffer);
  const column = ({ type, at, count, of }) => {
    if (type === "u1") return new Uint8Array(buffer, at, count);
    if (type === "u2") return new Uint16Array(buffer, at, count);
    if (type === "u4") return new Uint32Array(buffer, at, count);
    if (type === "json") return JSON.parse(new TextDecoder().decode(bytes.subarray(at, at + count)));
    if (type === "coded") {
      const values = column(of[0]), codes = column(of[1]);
      return Float64Array.from(codes, (code) => values[code]);
    }
    if (type === "steps") {
      // Each is the step from the number before: 0, 1, 2, 3 stand for 0, -1, 1, -2.
      let last = 0;
      return Float64Array.from(column(of[0]), (step) => (last += step % 2 ? -(step + 1) / 2 : step / 2));
    }
    // f8: the first bytes of all numbers, then the second ones, and so on: so they deflate better.
    const numbers = new Float64Array(count), placed = new Uint8Array(numbers.buffer);
    for (let plane = 0; plane < 8; plane += 1) {
      for (let i = 0, from = at + plane * count; i < count; i += 1) placed[8 * i + plane] = bytes[from + i];
    }
    return numbers;
  };
  return column;
};
