// Numbers, units, times and paths as a reader expects them.

const thinSpace = "\u202f";
const units = { _m2: "m²", _m: "m", _cm: "cm", _mm: "mm", _px: "px", _deg: "°", _s: "s", _mb: "MB" };

const plain = name => name.replaceAll("_", " ");
const counted = (count, word) => `${figureText(count)} ${word}${count === 1 ? "" : "s"}`;

/// Whole, with thin spaces between thousands from five digits on, or of four significant digits.
function figureText(number) {
    const size = Math.abs(number);
    if (!Number.isFinite(number))
        return "not finite";
    if ((!Number.isInteger(number) && size < 1000) || size >= 1e15)
        return String(Number(number.toPrecision(4))).replace("-", "−");
    const digits = String(Math.round(size));
    return (number < 0 ? "−" : "") + (digits.length > 4 ? digits.replace(/\B(?=(\d{3})+$)/g, thinSpace) : digits);
}

/// "412 bytes", "3.1 kB", "12.3 MB", of 1000 each.
function bytesText(bytes) {
    if (bytes < 1000)
        return `${Math.round(bytes)} bytes`;
    const power = Math.min(3, Math.floor(Math.log10(bytes) / 3));
    return `${(bytes / 1000 ** power).toFixed(1)} ${["", "kB", "MB", "GB"][power]}`;
}

/// "4.1 s", "41 s", "2:03 min", "1:02:03 h".
function durationText(seconds) {
    const whole = Math.round(seconds);
    const two = number => String(number).padStart(2, "0");
    if (seconds < 10)
        return `${seconds.toFixed(1)} s`;
    if (whole < 60)
        return `${whole} s`;
    if (whole < 3600)
        return `${Math.floor(whole / 60)}:${two(whole % 60)} min`;
    return `${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)} h`;
}

/// A path below the page's folder as a relative address: nothing in it is taken for a scheme, a query or an anchor.
const addressOf = path => "./" + path.split("/").map(encodeURIComponent).join("/");

/// "largest_angle_deg", 70 -> ["largest angle", "70 °"]. The unit is read off the name's end, but not of a rate.
function named(name, value) {
    const without = end => plain(name.slice(0, -end.length) || name);
    if (typeof value === "string")
        return [plain(name), value];
    if (typeof value === "boolean")
        return [plain(name), value ? "yes" : "no"];
    if (value === null)
        return [plain(name), "not finite"];
    if (name.endsWith("_share"))
        return [without("_share"), `${figureText(Number((100 * value).toPrecision(4)))} %`];
    if (/(^|_)bytes$/.test(name))
        return [plain(name), bytesText(value)];
    if (/(^|_)seconds$/.test(name))
        return [plain(name), durationText(value)];
    const end = name.includes("_per_") ? undefined : Object.keys(units).find(ending => name.endsWith(ending));
    return end ? [without(end), `${figureText(value)} ${units[end]}`] : [plain(name), figureText(value)];
}

/// "−38.5 %", "×4"; empty where there is nothing to compare.
function changeText(before, after) {
    if (typeof before !== "number" || typeof after !== "number" || before === 0 || before === after)
        return "";
    const factor = after / before;
    const digits = number => String(Number(number.toPrecision(3)));
    return factor >= 3 ? `×${digits(factor)}` : (factor < 1 ? "−" : "+") + `${digits(Math.abs(100 * (factor - 1)))} %`;
}

/// What a stage reported, in words: [{label, value, before, change}]. Maps are walked into; lists, judged frames and the table are shown
/// on their own. X_before and X_after become one figure.
function figuresOf(report, prefix = "") {
    const figures = [];
    for (const [name, value] of Object.entries(report)) {
        if (Array.isArray(value) || (prefix === "" && ["judged_frames", "table"].includes(name)))
            continue;
        if (typeof value === "object" && value !== null) {
            figures.push(...figuresOf(value, `${prefix}${name}_`));
            continue;
        }
        const stem = name.replace(/_(before|after)$/, "");
        const [before, after] = [`${stem}_before`, `${stem}_after`];
        const paired = before in report && after in report;
        if (paired && name === before)
            continue;
        const [label, text] = named(prefix + (paired ? stem : name), value);
        figures.push({ label, value: text, before: paired ? named(stem, report[before])[1] : "", change: paired ? changeText(report[before], value) : "" });
    }
    return figures;
}
