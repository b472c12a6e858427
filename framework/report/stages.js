// A card for each stage: what it came to, what it said, how it was set.

const figuresList = figures => figures.length
    ? definitions(figures.map(({ label, value, before, change }) => [label, before && `${before} → `, value, change && element("span", { class: "change" }, ` ${change}`)]))
    : null;

function reportTable(table) {
    if (!Array.isArray(table?.columns) || !Array.isArray(table.rows) || !table.rows.length)
        return null;
    return tableOf(table.columns, table.rows.filter(Array.isArray).map(row => row.map(value => ["number", "string"].includes(typeof value) ? value : "")));
}

/// A message is {message: text} or {warning: text}.
const messageLines = messages => messages.flatMap(message => Object.entries(message)).map(([kind, text]) =>
    element("p", { class: kind === "warning" ? "bad" : "soft" }, kind === "warning" ? `warning: ${text}` : text));

const valueText = value => typeof value === "string" ? value : JSON.stringify(value);
const code = text => element("code", {}, text);
const folded = (title, ...content) => element("details", {}, element("summary", {}, title), ...content);

const listed = map => definitions(Object.entries(map).map(([name, value]) => [name, code(valueText(value))]));

function optionsList(stage) {
    const inputs = stage.inputs.map(input => [input.port, code(input.stage ? `${input.stage}.${input.output}` : input.file)]);
    return inputs.length + Object.keys(stage.options).length === 0 ? null : folded("inputs and options", definitions(inputs), listed(stage.options));
}

function costText(stage) {
    const parts = [stage.state];
    if (stage.seconds > 0)
        parts.push(wasStored(stage) ? `took ${durationText(stage.seconds)} when it was made` : durationText(stage.seconds));
    if (stage.memory_mb > 0)
        parts.push(`${bytesText(stage.memory_mb * 1048576)} memory`);
    if (stage.disk_mb > 0)
        parts.push(`${bytesText(stage.disk_mb * 1048576)} stored`);
    return parts.join(" · ");
}

const stageCard = (stage, number) => element("article", { class: "stage", id: `stage-${number}` },
    element("header", {}, element("h3", {}, stage.name), code(stage.type), element("span", { class: stage.state === "failed" ? "cost bad" : "cost" }, costText(stage))),
    element("p", { class: "soft" }, stage.help),
    stage.error ? element("div", { class: "error" }, stage.error) : null,
    messageLines(stage.messages), reportTable(stage.figures.table), figuresList(figuresOf(stage.figures)), optionsList(stage));
