// What was checked, as lines of a table and as JSON. A result is plain data:
//   {file, program, splats, attributes: {name: {worst, allowed, agrees}}}   two clouds compared
//   {file, program, problems}                                               right if there are none

const attributeNames = ['position', 'scale', 'rotation', 'opacity', 'sh_dc', 'sh_rest'];

/** The result of a comparison: each attribute is a check. */
export function comparison(file, program, splats, worst, allowed) {
  if (!worst) return {file, program, problems: ['the numbers of splats or the degrees differ']};
  const attributes = {};
  for (const [name, value] of Object.entries(worst)) {
    attributes[name] = {worst: value, allowed: allowed[name], agrees: value <= allowed[name]};
  }
  return {file, program, splats, attributes};
}

/** Whether each check of a result agrees. */
const checksOf = (result) => result.attributes
  ? Object.values(result.attributes).map(({agrees}) => agrees)
  : [result.problems.length === 0];

export function countChecks(results) {
  const checks = results.flatMap(checksOf);
  return {total: checks.length, failed: checks.filter((agrees) => !agrees).length};
}

/** Three digits, with an exponent where that is shorter. */
function short(value) {
  if (value === 0 || !Number.isFinite(value)) return String(value);
  if (value < 1e-3 || value >= 1e4) return value.toExponential(1);
  return String(Number(value.toPrecision(3)));
}

function rowOf(result) {
  const {file, program, splats, attributes, problems} = result;
  if (problems) return [file, program, problems.length === 0 ? 'agrees' : 'WRONG'];
  return [file, program, String(splats), ...attributeNames.map((name) => {
    const value = attributes[name];
    if (!value) return '';
    return `${short(value.worst)} (${short(value.allowed)})${value.agrees ? '' : ' BEYOND'}`;
  })];
}

export function tableOf(results) {
  const rows = [['file', 'program', 'splats', ...attributeNames], ...results.map(rowOf)];
  const widths = rows[0].map((_, c) => Math.max(...rows.map((row) => (row[c] ?? '').length)));
  return rows.flatMap((row, i) => [
    row.map((cell, c) => cell.padEnd(widths[c])).join('  ').trimEnd(),
    ...(results[i - 1]?.problems ?? []).map((line) => `    ${line}`),
  ]);
}
