// Curves over a stage's progress, and a bar per judged frame.

const chart = { width: 560, height: 190, left: 64, right: 8, top: 10, bottom: 24 };

/// Round numbers within [low, high], about `count` of them, ascending.
function roundTicks(low, high, count) {
    if (!(high > low))
        return [low];
    const rough = (high - low) / count;
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = power * [1, 2, 5, 10][[1.5, 3, 7, Infinity].findIndex(limit => rough / power <= limit)];
    const ticks = [];
    for (let index = Math.ceil(low / step - 1e-9); index * step <= high + 1e-9 * step; ++index) {
        // So far from 0 that the next whole number is the same.
        if (ticks.length && index * step <= ticks.at(-1))
            break;
        ticks.push(index * step || 0);
    }
    return ticks;
}

/// The mean over a window around each value that grows with their number.
const smoothed = values => values.map((_, i) => {
    const reach = Math.min(Math.floor(values.length / 40), i, values.length - 1 - i);
    return values.slice(i - reach, i + reach + 1).reduce((sum, value) => sum + value, 0) / (2 * reach + 1);
});

/// From values to places in a chart. Logarithmic where all are positive and the largest is more than thirty times the smallest.
function axesOf(points) {
    const values = points.map(([, y]) => y);
    const [low, high] = [Math.min(...values), Math.max(...values)];
    const logarithmic = low > 0 && high > 30 * low;
    const scaled = value => logarithmic ? Math.log10(value) : value;
    const from = logarithmic || low < 0 || high / 2 < low ? low : 0;
    const place = (value, begin, end, start, size) => start + (value - begin) / (end > begin ? end - begin : 1) * size;
    const [begin, end] = [points[0][0], points.at(-1)[0]];
    const powers = () => Array.from({ length: Math.floor(Math.log10(high)) - Math.ceil(Math.log10(low)) + 1 }, (_, i) => 10 ** (Math.ceil(Math.log10(low)) + i));
    return {
        x: value => place(value, begin, end, chart.left, chart.width - chart.left - chart.right),
        y: value => place(scaled(value), scaled(from), scaled(high), chart.height - chart.bottom, chart.top + chart.bottom - chart.height),
        columns: roundTicks(begin, end, 6),
        rows: logarithmic ? powers() : roundTicks(from, high, 4),
        low,
    };
}

const pathOf = places => places.map(([x, y], i) => `${i === 0 ? "M" : "L"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");

function curveChart(name, unit, points) {
    const axes = axesOf(points);
    const means = smoothed(points.map(([, y]) => y));
    const label = plain(name);
    return element("figure", {},
        svg("svg", { class: "chart", viewBox: `0 0 ${chart.width} ${chart.height}`, role: "img", "aria-label": label },
            axes.rows.map(tick => [
                svg("path", { class: "grid", d: `M${chart.left} ${axes.y(tick).toFixed(1)}H${chart.width - chart.right}` }),
                svg("text", { x: chart.left - 6, y: axes.y(tick) + 4, class: "end" }, figureText(tick))]),
            axes.columns.map(tick => svg("text", { x: axes.x(tick), y: chart.height - 7, class: "middle" }, figureText(tick))),
            svg("path", { class: "raw", d: pathOf(points.map(([x, y]) => [axes.x(x), axes.y(y)])) }),
            svg("path", { class: "smooth", d: pathOf(points.map(([x], i) => [axes.x(x), axes.y(means[i])])) })),
        element("figcaption", {}, `${label} over ${unit || "time"}: first ${figureText(points[0][1])}, last ${figureText(points.at(-1)[1])}, least ${figureText(axes.low)}`));
}

/// A chart per metric that has two points or more.
const curveCharts = curves => Object.entries(curves?.metrics ?? {}).flatMap(([name, values]) => {
    const points = curves.done.map((done, i) => [done, values[i]]).filter(([, value]) => typeof value === "number");
    return points.length > 1 ? [curveChart(name, curves.unit, points)] : [];
});

/// For the "judged_frames" that a stage reports: a bar per frame; beyond a thousand frames, the largest of each few. Null where
/// the lists are not of one length.
function barsOf({ names, values, kept, beyond, least = 0, most = Infinity }) {
    if (!Array.isArray(names) || !names.length || values?.length !== names.length || kept?.length !== names.length)
        return null;
    const all = names.map((name, i) => {
        const value = typeof values[i] === "number" ? values[i] : 0;
        return { name, value, verdict: kept[i] ? "kept" : beyond?.[i] ?? (value < least || value > most) ? "beyond" : "dropped" };
    });
    const each = Math.ceil(all.length / 1000);
    const bars = Array.from({ length: Math.ceil(all.length / each) }, (_, bar) =>
        all.slice(bar * each, (bar + 1) * each).reduce((best, one) => one.value > best.value ? one : best));
    const counts = { kept: 0, beyond: 0, dropped: 0 };
    all.forEach(({ verdict }) => ++counts[verdict]);
    return { bars, counts };
}

function judgedChart(judged) {
    const found = barsOf(judged);
    if (!found)
        return null;
    const { bars, counts } = found;
    const { measure, least, most } = judged;
    const limit = least ?? most ?? 0;
    const [width, height, top] = [1000, 150, 6];
    const scale = (height - top) / Math.max(limit, ...bars.map(({ value }) => value), 1e-300);
    const step = width / bars.length;
    const keys = [["kept", "kept"], ["beyond", `${most === undefined ? "below" : "above"} ${measure} ${figureText(limit)}`], ["dropped", "dropped beside others"]];
    return element("figure", {},
        svg("svg", { class: "judged", viewBox: `0 0 ${width} ${height}`, preserveAspectRatio: "none", role: "img", "aria-label": `${measure} of every frame` },
            bars.map(({ name, value, verdict }, i) => {
                const size = Math.max(1, value * scale);
                return svg("rect", { class: verdict, x: (i * step).toFixed(2), y: (height - size).toFixed(1), width: Math.max(0.5, step * 0.85).toFixed(2), height: size.toFixed(1) },
                    svg("title", {}, `${name}: ${measure} ${figureText(value)}${verdict === "kept" ? "" : ", dropped"}`));
            }),
            limit > 0 ? svg("path", { class: "limit", d: `M0 ${height - limit * scale}H${width}` }) : null),
        element("figcaption", {}, `${measure} of ${figureText(judged.names.length)} frames in recorded order: `,
            keys.filter(([verdict]) => verdict === "kept" || counts[verdict] > 0).map(([verdict, text]) =>
                element("span", { class: "key" }, element("i", { class: verdict }), `${figureText(counts[verdict])} ${text}`))));
}
