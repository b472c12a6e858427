// What there is to look at: the slider between camera pictures and renders, and all other pictures.

const stemOf = name => name.split("/").at(-1).replace(/\.[^.]*$/, "");
const fileOf = (entry, picture) => entry.folder ? `${entry.folder}/${picture.name}` : picture.name;

/// What stages made under the names of recorded frames, of the stage with the most of them: {entry, views: [{name, camera, render, pose}]}.
function viewsOf(media) {
    const recorded = new Map(media.filter(entry => entry.cameras).flatMap(entry => entry.pictures ?? []).map(picture => [picture.name, picture]));
    const all = media.filter(entry => entry.folder !== undefined).map(entry => ({
        entry,
        views: (entry.pictures ?? []).filter(picture => recorded.has(stemOf(picture.name))).map(picture => {
            const { name, uri, pose } = recorded.get(stemOf(picture.name));
            return { name, camera: uri, render: picture.uri, pose };
        }),
    }));
    return all.reduce((best, each) => each.views.length > best.views.length ? each : best, { views: [] });
}

/// `standAt(pose)` puts the visitor of the room there; null where there is no room.
function compareSection({ views, entry }, standAt) {
    if (!views.length)
        return null;
    const under = element("img", { alt: "camera picture" });
    const over = element("img", { class: "over", alt: "render" });
    const slider = element("input", { type: "range", min: 0, max: 100, value: 50, step: 0.1, "aria-label": "How much of the camera picture is shown", oninput: () => cut() });
    const compare = element("div", { class: "compare" }, under, over, slider, element("span", { class: "edge" }),
        element("span", { class: "tag left" }, "camera"), element("span", { class: "tag right" }, "render"));
    const caption = element("span", { id: "view-name" });
    const thumbs = views.map((view, number) => element("button", { title: view.name, onclick: () => choose(number) }, element("img", { alt: view.name, src: view.render })));
    const cut = () => compare.style.setProperty("--cut", `${slider.value}%`);
    let shown = 0;
    const choose = number => {
        shown = number;
        [under.src, over.src, caption.textContent] = [views[number].camera, views[number].render, views[number].name];
        thumbs.forEach((thumb, other) => thumb.setAttribute("aria-pressed", other === number));
    };
    choose(0);
    cut();
    return section("Camera and render", compare,
        element("div", { class: "bar" }, caption, standAt && element("button", { id: "stand-here", onclick: () => standAt(views[shown].pose) }, "Stand here in the room")),
        element("div", { class: "thumbs" }, thumbs), element("p", { class: "soft" }, `rendered by ${entry.stage}`));
}

const pictureOf = (uri, name) => uri.startsWith("data:video/") ? element("video", { controls: true, loop: true, src: uri, title: name }) : element("img", { src: uri, alt: name });

const captioned = (picture, name, caption) => element("figure", {}, pictureOf(picture.uri, name), element("figcaption", {}, caption));

/// Pictures that no file holds: [{entry, picture, ports}], with the ports of the stages that read them.
const ownPictures = (data, media) => media.filter(entry => entry.folder === undefined && !entry.cameras).flatMap(entry => {
    const readers = data.stages.flatMap(stage => stage.inputs).filter(input => input.stage === entry.stage && input.output === entry.port).map(input => input.port);
    return (entry.pictures ?? []).map(picture => ({ entry, picture, ports: entry.file ? [entry.port] : [...new Set(readers)] }));
});

/// What stages painted after: "style: waves.jpg".
const inputPictures = (data, media) => ownPictures(data, media).filter(({ picture, ports }) => ports.length && !picture.section).map(({ entry, picture, ports }) =>
    captioned(picture, entry.stage, `${ports.join(", ")}: ${entry.file ? entry.file.split("/").at(-1) : entry.stage}`));

/// A section for each title that pictures ask for: "The atlas".
function titledPictures(data, media) {
    const titled = ownPictures(data, media).filter(({ picture }) => picture.section);
    return [...new Set(titled.map(({ picture }) => picture.section))].map(title => section(title, element("div", { class: "titled" },
        titled.filter(({ picture }) => picture.section === title).map(({ entry, picture }) => captioned(picture, title, `${entry.stage}, ${picture.name}`)))));
}

function otherPictures(data, media, compared) {
    const files = media.filter(entry => entry.folder !== undefined && entry !== compared).flatMap(entry => (entry.pictures ?? []).map(picture => {
        const file = fileOf(entry, picture);
        return captioned(picture, file, link(file, file));
    }));
    const unread = ownPictures(data, media).filter(({ picture, ports }) => !ports.length && !picture.section)
        .map(({ entry, picture }) => captioned(picture, entry.stage, `${entry.stage}.${entry.port}`));
    return files.length + unread.length ? section("Other pictures", element("div", { class: "pictures" }, unread, files)) : null;
}
