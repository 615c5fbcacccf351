// The points of a study, and its figures.
const readStudy = async (head, packed) => {
  const column = await readColumns(packed);
  const axes = head.axes.map((axis) => ({ ...axis, level: column(axis.level), isAxis: true }));
  const frames = head.frames.map((frame) => ({
    name: frame.name,
    feasible: column(frame.feasible),
    front: column(frame.front),
    why: column(frame.why),
    // A column is read when it is first asked for.
    figures: frame.figures.map((figure) => {
      let values = null;
      return { ...figure, get values() { return (values ??= column(figure.column)); } };
    }),
  }));
  return { ...head, points: column(head.points), whys: column(head.whys), axes, frames };
};
