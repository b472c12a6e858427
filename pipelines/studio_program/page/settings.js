// Controls made of what the plugins declare: range, default, help. The few that matter come first.

/// Settings by name: the type whose option it is, and what people call it; `to`: where the slider ends if the range goes far beyond; `both`: of either method.
const few = [
    ["method", null, "Method"],
    ["texture.stroke_cm", "texture.synthesize", "Stroke width, cm", { to: 20, step: 0.5 }],
    ["texture.painterly", "texture.synthesize", "Painterly"],
    ["texture.detail", "texture.synthesize", "Detail"],
    ["strength.color", "texture.mix", "Strength of color"],
    ["strength.strokes", "texture.mix", "Strength of strokes"],
    ["keep", null, "Keep as photographed"],
    ["walls", null, "Picture for walls"],
    ["texture.theta_d_m", "texture.optimize", "Pattern size (theta_d), m", { to: 0.5, step: 0.01 }],
    ["texture.epochs", "texture.optimize", "Visits to each view (epochs)", { to: 20 }],
    ["texture.repeats_count", "texture.optimize", "Steps per visit (repeats)", { to: 20 }],
    ["texture.stop_at_step", "texture.optimize", "Stop at step", { empty: "none" }],
    ["atlas.size_px", "atlas.project", "Size of the texture, px", { choices: [1024, 2048, 4096], both: true }],
    ["relief.height_mm", "texture.relief", "Relief, mm", { off: true, to: 10, step: 0.5, both: true, of: ["recording", "splat"] }],  // export.model keeps materials.
];
const rest = [
    ...["direction", "recolor", "levels_count", "rounds_count"].map(name => [`texture.${name}`, "texture.synthesize", name.replace("_count", "").replace(/^./, first => first.toUpperCase())]),
    ["texture.init", "texture.optimize", "Start from (init)"],
    ["texture.angle_limit_deg", "texture.optimize", "Angle filter, degrees"],
    ["texture.lambda_r", "texture.optimize", "Regularizer (lambda_r)"],
    ["texture.rate", "texture.optimize", "Learning rate"],
    ["texture.seed", "texture.synthesize", "Seed", { both: true }],
];
/// What pipelines/stylemesh.yaml sets in place of the plugins' defaults.
const of_stylemesh = { "texture.theta_d_m": 0.12, "texture.epochs": 7, "texture.repeats_count": 10, "texture.init": "zeros", "texture.angle_limit_deg": 30, "texture.lambda_r": 5000, "texture.rate": 1, "atlas.size_px": 4096 };
const of_file = [
    ["unit_m", "scan.mesh", "Meters per unit of the file", { of: ["model", "splat"], both: true }],
    ["up", "texture.synthesize", "Which way is up", { of: ["model", "splat"], both: true }],
];
const of_file_asked = /\b(?:set|option|does) (unit_m|up)\b|^(up): /;  // Texts that ask for one of them.
const regions = ["floor", "walls", "ceiling", "furniture"];

const element = (name, properties = {}, ...children) => {
    const made = Object.assign(document.createElement(name), properties);
    made.append(...children);
    return made;
};

class Settings {
    /// `declarations`: of `fresco describe TYPE --json`, by type. `changed()` is called after each change by the user.
    constructor(declarations, changed) {
        this.values = {};
        this.rows = new Map();
        this.changed = changed;
        for (const [list, place] of [[few, "settings"], [of_file, "more_settings"], [rest, "more_settings"]])
            for (const [name, type, label, more = {}] of list) {
                if (type && !declarations[type])
                    continue;
                const option = type && declarations[type].declaration.options.find(each => each.name === name.split(".").at(-1));
                const row = name === "method" ? this.method(label) : name === "keep" ? this.keeping(label) : name === "walls" ? this.walls(label) : this.row(name, label, option, more);
                row.method = more.both || name === "method" ? null : type === "texture.optimize" ? "stylemesh" : "strokes";
                row.of = more.of;
                this.rows.set(name, row);
                document.getElementById(place).append(row.box);
            }
        this.show({});
    }

    set(name, value) {
        if (value === undefined)
            delete this.values[name];
        else
            this.values[name] = value;
        this.rows.get(name).box.querySelector(".advice")?.remove();
        this.show(this.values);
        this.changed();
    }

    /// What holds where nothing is chosen.
    usual(name, option) {
        return (this.values.method && of_stylemesh[name]) ?? (name === "up" && this.kind === "model" ? "y" : option.default);  // model.yaml has y up.
    }

    /// Those of `values` that another method has, too.
    common(values, method) {
        const kept = Object.entries(values).filter(([name]) => name !== "method" && [null, method ?? "strokes"].includes(this.rows.get(name)?.method ?? null));
        return { ...Object.fromEntries(kept), ...(method ? { method } : {}) };
    }

    /// Shows other values; what is not among them has its default.
    show(values) {
        this.values = { ...values };
        for (const [name, row] of this.rows) {
            row.show(this.values[name]);
            row.box.classList.toggle("changed", this.values[name] !== undefined);
            row.box.classList.toggle("other", (row.method ?? this.values.method ?? "strokes") !== (this.values.method ?? "strokes"));
            row.box.querySelector(".error")?.remove();
        }
    }

    /// Shows an error at the setting that it names, where there is one.
    complain(text, className = "error") {
        const name = of_file_asked.exec(text)?.slice(1).find(Boolean) ?? [...this.rows.keys()].find(each => each !== "method" && this.values[each] !== undefined && text.includes(each.split(".").at(-1)));
        if (!name)
            return;
        const { box } = this.rows.get(name);
        box.querySelector(`.${className}`)?.remove();
        box.append(element("p", { className, textContent: text }));
        if (box.closest("details"))
            box.closest("details").open = true;
    }

    /// Shows warnings about the file that a setting would answer, until it is set or another scan is chosen.
    advise(warnings) {
        for (const text of warnings.filter(each => of_file_asked.test(each)))
            this.complain(text, "advice");
    }

    box(name, label, help, ...controls) {
        const id = `set-${name.replace(".", "-")}`;
        const caption = element("label", { htmlFor: id, textContent: label });
        const box = element("div", { className: "setting", title: help ? `${name}: ${help}` : name }, caption, ...controls);
        controls.at(-1).id = id;
        return box;
    }

    method(label) {
        const make = (method, textContent) => {
            const button = element("button", { textContent, title: method ? "" : "texture.synthesize: brush strokes after the picture, in a minute" });
            button.addEventListener("click", () => {
                if (this.values.method === method)
                    return;
                this.values = this.common(this.values, method);
                this.set("method", method);
            });
            return button;
        };
        const strokes = make(undefined, "brush strokes");
        this.stylemesh = make("stylemesh", "StyleMesh");
        const choices = element("div", { className: "segments", role: "group", ariaLabel: label }, strokes, this.stylemesh);
        return {
            box: this.box("method", label, "", choices), show: given => {
                strokes.setAttribute("aria-pressed", !given);
                this.stylemesh.setAttribute("aria-pressed", Boolean(given));
            },
        };
    }

    /// `lack`: why StyleMesh cannot be chosen; empty: it can.
    offerStyleMesh(lack) {
        this.stylemesh.disabled = Boolean(lack);
        this.stylemesh.title = lack || "texture.optimize: optimizes the texture in all views, in hours";
    }

    row(name, label, option, { to, step, choices, off, empty: blank }) {
        const value = text => Number(text) === this.usual(name, option) && !off ? undefined : Number(text);
        if (option.kind === "bool") {
            const input = element("input", { type: "checkbox" });
            input.addEventListener("change", () => this.set(name, input.checked === option.default ? undefined : input.checked));
            return { box: this.box(name, label, option.help, input), show: given => { input.checked = given ?? option.default; } };
        }
        if (option.choices || choices) {
            const select = element("select", {}, ...(option.choices ?? choices).map(each => element("option", { value: each, textContent: each })));
            select.addEventListener("change", () => this.set(name, option.choices ? (select.value === this.usual(name, option) ? undefined : select.value) : value(select.value)));
            return { box: this.box(name, label, option.help, select), show: given => { select.value = given ?? this.usual(name, option); } };
        }
        const number = element("input", { type: "number", min: option.min, max: option.max, step: option.kind === "int" ? 1 : "any" });
        number.addEventListener("change", () => this.set(name, number.value === "" || (off && Number(number.value) === 0) ? undefined : value(number.value)));
        const box = this.box(name, label, option.help, number);
        let range = null;
        if (to || option.max <= 100) {
            range = element("input", { type: "range", min: off ? 0 : option.min, max: to ?? option.max, step: step ?? (option.kind === "int" ? 1 : 0.01), ariaLabel: label });
            range.addEventListener("input", () => { number.value = Number(range.value) || !off ? range.value : ""; });
            range.addEventListener("change", () => this.set(name, off && Number(range.value) === 0 ? undefined : value(range.value)));
            box.append(range);
        }
        if (off || blank || (option.default === 0 && to))
            number.placeholder = blank ?? (off ? "none" : "auto");
        return {
            box, show: given => {
                const empty = given === undefined && number.placeholder;
                number.value = number.defaultValue = empty ? "" : given ?? this.usual(name, option);  // They differ while it is typed.
                if (range)
                    range.value = given ?? (off ? 0 : this.usual(name, option));
            },
        };
    }

    keeping(label) {
        const boxes = regions.map(region => element("input", { type: "checkbox", value: region }));
        const choices = element("div", { className: "choices" }, ...boxes.map(box => element("label", {}, box, box.value)));
        for (const box of boxes)
            box.addEventListener("change", () => {
                const kept = boxes.filter(each => each.checked).map(each => each.value);
                this.set("keep", kept.length ? kept : undefined);
            });
        return { box: this.box("keep", label, "Regions that stay as the camera saw them (texture.regions)", choices), show: given => boxes.forEach(box => { box.checked = given?.includes(box.value) ?? false; }) };
    }

    walls(label) {
        this.wall_pictures = element("select", {}, element("option", { value: "", textContent: "same picture" }));
        this.wall_pictures.addEventListener("change", () => this.set("walls", this.wall_pictures.value || undefined));
        return { box: this.box("walls", label, "Another picture for walls and ceiling (texture.regions)", this.wall_pictures), show: given => { this.wall_pictures.value = given ?? ""; } };
    }

    /// Offers what goes with that kind of scan.
    suit(kind, scan) {
        if (scan !== this.scan)
            document.querySelectorAll(".advice").forEach(each => each.remove());
        Object.assign(this, { kind, scan });
        for (const { box, of } of this.rows.values())
            box.hidden = Boolean(of && !of.includes(kind));
        this.rows.get("up").show(this.values.up);
    }

    offer(pictures) {
        this.wall_pictures.replaceChildren(this.wall_pictures.options[0], ...pictures.map(name => element("option", { value: name, textContent: shortName(name) })));
        this.wall_pictures.value = this.values.walls ?? "";
    }
}
