//! The page: all tables and graphs of a reproduction in one HTML file that needs no other.

use super::{bars, plot, tables};
use crate::size::Size;
use crate::surface::{self, Loaded};
use crate::table::{Table, escaped};
use saarcor_model::vm::Bytes;
use saarcor_paper::claims::Claim;
use saarcor_paper::reproduction::{Extent, Reproduction};
use saarcor_studies::simulate::WarmUp;
use std::fmt::Write as _;

const STYLE: &str = include_str!("../page.css");

/// Why ours differ from the paper's.
const DIFFERENCES: &[(&str, &str)] = &[
    (
        "The scenes are others.",
        "The paper's scenes and camera paths are not public. Ours are generated, of the same kind, with the \
         same numbers of triangles and lights and the same bytes of textures; each figure depends on what the \
         camera sees, so compare shapes and magnitudes, not digits.",
    ),
    (
        "Geometry is counted otherwise.",
        "The paper's MB are files on disk, as large with as without textures and lights, so they hold fields \
         that a variant does not need. Ours are the bytes that the chip reads: a kd-node of 8 bytes, a list \
         entry of 4, a triangle of 36, and a shading record of 16 to 92 bytes that holds only what the scene \
         needs. With all 92, pQuake3 would take 166 bytes a triangle; what else the paper's 362 are, it does \
         not say. Its 156 of the Cruiser are near ours.",
    ),
    (
        "The kd-tree is another.",
        "Ours is built by the surface area heuristic; the paper says that its own was not the best (§4), and \
         a worse tree reads more nodes, lists and triangles a ray.",
    ),
    (
        "Mip maps are assumed.",
        "The paper names no filter. With mip maps pQuake3 reads about as much as the paper's rows with textures do, \
         without them ten times that (SPEC.md has the measurement). Table 1 counts images without the coarser \
         levels, which are a third more.",
    ),
    (
        "Some choices are ours.",
        "The paper names neither the picture's size, nor the replacement policy, nor how often the upper \
         address bits are folded in: 1024 × 768, FIFO and one fold are assumed. Nor does it name the \
         chip's latencies, its first-level lines or the memory's banks; SPEC.md says which of Table 2's \
         relations hang on them.",
    ),
];

/// Why ours differ from the paper's; of a scene of the user's, which is not in the paper, nothing.
pub fn differences(report: &Reproduction) -> &'static [(&'static str, &'static str)] {
    if report.scene.is_none() { DIFFERENCES } else { &[] }
}

/// The page.
pub fn html(report: &Reproduction) -> String {
    let [metadata, scenes, hot_spots, chip] = tables::sections(report).map(|tables| {
        let element = |(caption, table): (String, Table)| {
            format!("<div class=\"scroll\">{}</div>\n", table.to_html(&caption))
        };
        tables.into_iter().map(element).collect::<String>()
    });
    let mut details = String::new();
    for Claim { id, claim, numbers, open, verdict, .. } in &report.claims {
        let left = (!open.is_empty()).then(|| format!("Left open: {open}"));
        let numbers: Vec<_> = numbers.iter().chain(&left).map(|number| escaped(number)).collect();
        let (claim, numbers) = (escaped(claim), numbers.join("<br>"));
        let _ = writeln!(details, "<dt>{id}: <em>{verdict}</em></dt><dd>{claim}<br>{numbers}</dd>");
    }
    let caption = "Each claim, and one thing changed: the figure with it and without";
    let claims =
        format!("<div class=\"scroll wrap\">{}</div>\n", tables::claims(&report.claims).to_html(caption));
    let mut drawn = String::new();
    for bars in &bars::ALL {
        let _ = write!(
            drawn,
            "<figure>\n<div class=\"scroll\">{}</div>\n<figcaption>(<a href=\"{1}.svg\">SVG</a>)</figcaption>\n</figure>\n",
            bars.svg(&report.table2),
            bars.file
        );
    }
    let mut graphs = String::new();
    for graph in &report.figure3 {
        let frames = match graph.step {
            1 => format!("all {} frames", graph.path_frames),
            step => format!("one in {step} of {} frames", graph.path_frames),
        };
        let _ = write!(
            graphs,
            "<figure>\n<div class=\"scroll\">{}</div>\n<figcaption>{}, {} of on-board memory, {frames} \
             (<a href=\"{3}.csv\">CSV</a>, <a href=\"{3}.svg\">SVG</a>)</figcaption>\n</figure>\n",
            plot::svg(graph),
            escaped(&graph.name),
            Size(Bytes(graph.memory_bytes)),
            plot::file(graph),
        );
        let hashed = graph.sizes.iter().filter(|row| row.hash);
        let loaded: Vec<_> =
            hashed.map(|row| Loaded { config: row.config, bytes: row.loaded_bytes }).collect();
        // A walk that loads nothing has no picture.
        if let Ok(drawing) =
            surface::svg(&loaded, &format!("sizes-{}", plot::file(graph)), &graph.name, graph.frames.len())
        {
            let _ = write!(
                graphs,
                "<figure>\n<div class=\"scroll\">{drawing}</div>\n<figcaption>{}: the same frames with on-board memories, lines and \
                 ways of other sizes</figcaption>\n</figure>\n",
                escaped(&graph.name),
            );
        }
    }
    let note = match report.extent {
        Extent::Quick if tables::skips_frames(report) => QUICK_NOTE,
        Extent::Quick => SMALL_NOTE,
        Extent::Some if tables::skips_frames(report) => SOME_NOTE,
        Extent::Some | Extent::All => "",
    };
    let mut why = String::new();
    for (what, because) in differences(report) {
        let _ = writeln!(why, "<dt>{what}</dt><dd>{because}</dd>");
    }
    let title = match &report.scene {
        None => "The paper's figures, ours beside theirs".to_owned(),
        Some(scene) => format!("{}: the paper's figures of this scene", escaped(scene)),
    };
    let section = |title: &str, text: &str, content: &str| match content {
        "" => String::new(),
        content => format!("<h2>{title}</h2>\n{text}{content}"),
    };
    let list =
        |content: &str| if content.is_empty() { String::new() } else { format!("<dl>\n{content}</dl>\n") };
    let sections = [
        section("What the paper claims", CLAIMS_TEXT, &format!("{claims}{}", list(&details))),
        section("Metadata", "", &metadata),
        section("Scenes", "", &scenes),
        section("Walks", WALKS_TEXT, &format!("{graphs}{hot_spots}")),
        section("Chip", &chip_text(report.warm_up), &format!("{chip}{drawn}")),
        section("What differs, and why", "", &list(&why)),
    ]
    .concat();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>SaarCOR virtual memory: {title}</title>\n<style>{STYLE}</style>\n</head>\n\
         <body>\n<main>\n<h1>{title}</h1>\n\
         <p>Schmittler, Leidinger, Slusallek: <cite>A Virtual Memory Architecture for Real-Time Ray Tracing \
         Hardware</cite> (2003). MB is 2<sup>20</sup> bytes.</p>\n{note}{sections}</main>\n</body>\n</html>\n"
    )
}

const CLAIMS_TEXT: &str = "<p>A claim is judged by runs. Its cause is the same figure where one thing is changed, mostly another run \
    of the chip: as the geometric mean, with and without, over the rows in which it is not zero (where it is in all, as the plain \
    mean). What is computed from a formula or taken of other frames of a walk says so. Below the table stand the numbers place by \
    place.</p>\n";

const WALKS_TEXT: &str = "<p>Step one of §4: a sequential ray tracer with the virtual memory and without first-level caches. The \
    working set is the distinct lines that a frame touches; transferred is what it loads from the host; a collision is the load of \
    a line that lay in the on-board memory earlier in the same frame. The on-board memory stays warm from frame to frame. \
    Frames a second are those of version A, each frame after the one before it: few of them ran on the chip, and the others are estimated from what is \
    cheap to count of all, where their interval of 95 % is at most half as wide as the number (the CSV has it).</p>\n";

fn chip_text(warm_up: WarmUp) -> String {
    let warmed = match warm_up {
        WarmUp::ONE => "after one frame that warms the caches".to_owned(),
        WarmUp::WALK => "after all frames before, which warm the caches".to_owned(),
        frames => format!("after {frames} frames that warm the caches"),
    };
    format!(
        "<p>Step two of §4: the hot spots of the walks on the whole chip, cycle by cycle, {warmed} (the first frame of a path has \
         none before it, and finds them empty); both in the order of their frames, and the same frames for all variants of a scene. \
         PCI is what a frame loads from the host, Mem what moves between the chip and the on-board memory.</p>\n"
    )
}

const QUICK_NOTE: &str = "<p class=\"note\"><strong>Quick form.</strong> The pictures are small, and the walks \
    skip frames. Fewer rays touch fewer lines and share less of what they read, so working sets are smaller and \
    more is read a ray than at full size; and from one frame shown to the next the camera moves further, so more \
    is transferred a frame than in a walk of all frames. Run without <code>--quick</code> for the paper's \
    measurement.</p>\n";

const SMALL_NOTE: &str = "<p class=\"note\"><strong>Quick form.</strong> The pictures are small. Fewer rays touch fewer lines and \
    share less of what they read, so working sets are smaller and more is read a ray than at full size. Run without \
    <code>--quick</code> for the paper's measurement.</p>\n";

const SOME_NOTE: &str = "<p class=\"note\"><strong>Some frames.</strong> The walks skip frames. From one frame \
    shown to the next the camera moves further, so more is transferred a frame than in a walk of all frames; run \
    with <code>--all-frames</code> for that.</p>\n";

#[cfg(test)]
mod tests {
    use super::super::csv;
    use super::*;
    use saarcor_model::time::Version;
    use saarcor_paper::claims::{Evidence, judge};
    use saarcor_paper::figure3::Graph;
    use saarcor_paper::fit::Fits;
    use saarcor_paper::metadata;
    use saarcor_paper::table1::SceneRow;
    use saarcor_paper::table2::{How, STANDARD, StandIn, hot_spots};
    use saarcor_paper::tables::table1;
    use saarcor_studies::monitor::Silent;
    use saarcor_studies::simulate::WarmUp;
    use saarcor_studies::standard;
    use saarcor_studies::trace::{PacketSize, TraceOptions};
    use saarcor_studies::walk::WalkOptions;
    use saarcor_studies::world::{World, WorldOptions};

    /// A report of which each row and each graph is about one small room.
    fn report() -> Reproduction {
        let room = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/room/room.obj");
        let world = World::open(&WorldOptions::new(room), &Silent).expect("a scene");
        let resolution = (32, 24);
        let trace = TraceOptions { resolution, packet: PacketSize::Rays64, max_bounces: 1 };
        let stand_in = StandIn { scene: "room", real: false, of: Some("Conference") };
        let how = How { setting: STANDARD, warm_up: WarmUp::ONE, trace: &trace };
        let table2 = hot_spots(stand_in, &world, &[1, 2], &how, &Silent).expect("chips");
        let metadata = metadata::examples();
        let cache = standard::cache("Conference").expect("a cache");
        let options = WalkOptions { cache, cold: false, trace };
        let mut graph = Graph::new("room", &world, &options, 2, 2, &Silent);
        let chip = standard::chip("Conference", Version::A).expect("a chip");
        graph.add_fps(&world, &chip, trace, &Silent).expect("a chip");
        let figure3 = vec![graph];
        let scenes = vec![SceneRow::new(&table1()[0], &world)];
        let cuts = table2[..1].to_vec();
        let evidence =
            Evidence { examples: &metadata, scenes: &scenes, graphs: &figure3, spots: &table2, cuts: &cuts };
        let (claims, fit) = (judge(evidence), Some(Fits::of(&table2)));
        Reproduction {
            scene: None,
            extent: Extent::Quick,
            resolution,
            warm_up: WarmUp::ONE,
            metadata,
            table1: scenes,
            figure3,
            memories: Vec::new(),
            table2,
            cuts,
            fit,
            claims,
        }
    }

    #[test]
    fn page_needs_no_other_file() {
        let html = html(&report());
        for element in ["html", "body", "table", "figure", "svg", "dl", "style", "title", "p"] {
            let begins =
                html.matches(&format!("<{element}>")).count() + html.matches(&format!("<{element} ")).count();
            assert_eq!(begins, html.matches(&format!("</{element}>")).count(), "{element}");
        }
        assert!(html.contains("<svg role=\"img\" aria-labelledby="));
        assert!(
            !html.contains("src=")
                && !html.contains("@import")
                && html.matches("url(").count() == html.matches("url(#").count()
        );
        let namespace = "http://www.w3.org/2000/svg";
        assert_eq!(html.matches("http").count(), html.matches(namespace).count());
    }

    #[test]
    fn quick_form_says_what_it_leaves_out() {
        let mut report = report();
        let page = html(&report);
        assert!(page.contains("Quick form.") && page.contains("one in 2 of 3 frames"), "{page}");
        report.extent = Extent::Some;
        let page = html(&report);
        assert!(!page.contains("Quick form.") && page.contains("Some frames."));
        report.extent = Extent::All;
        assert!(!html(&report).contains("class=\"note\""));
    }

    #[test]
    fn each_row_and_claim_is_shown() {
        let report = report();
        assert_eq!(report.table2.len(), 2);
        let page = html(&report);
        for claim in &report.claims {
            assert!(page.contains(&escaped(claim.claim)) && page.contains(&escaped(&claim.ours)));
            assert!(claim.numbers.iter().all(|number| page.contains(&escaped(number))));
            let cause = claim.cause.as_ref().unwrap_or_else(|| panic!("{} has no cause", claim.id));
            assert!(page.contains(&escaped(&cause.to_string())), "{}", claim.id);
        }
        assert!(page.contains("room 1") && page.contains("room 2"));
    }

    #[test]
    fn graphs_have_a_row_a_frame() {
        let graph = &report().figure3[0];
        assert_eq!(graph.frames.iter().map(|row| row.frame).collect::<Vec<_>>(), [0, 2]);
        let csv = csv(graph);
        assert!(csv.starts_with("frame,primary_rays,") && csv.ends_with('\n'));
        let commas = |line: &str| line.matches(',').count();
        assert_eq!(csv.lines().map(commas).collect::<Vec<_>>(), [15; 3]);
        assert!(csv.lines().nth(2).is_some_and(|row| row.starts_with("2,768,") && row.ends_with(",false")));
        assert!(graph.fps.iter().all(|row| row.fps.is_some_and(|fps| fps > 0.0)));
        assert!(plot::svg(graph).contains("frames a second (right)"));
    }
}
