//! Where the bytes of a frame go: by class of data, and at each level of the memories.

use crate::summary::REGION_NAMES;
use crate::world::Image;
use saarcor_fast::chip::{ChipObserver, Traffic};
use saarcor_model::host::region_starts;
use saarcor_model::time::{ChipConfig, Command, Direction, Load, SdramConfig, Span, TimingReport};
use saarcor_model::vm::HostAddr;
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::Range;

/// Watches the run of a frame, and counts its bytes by the region of the image in which they lie. The padding behind
/// a region counts as the region's.
#[derive(Clone, Debug)]
pub struct TrafficWatch {
    /// Where each region of [`REGION_NAMES`] begins and the image ends.
    starts: [u64; 6],
    sdram: SdramConfig,
    line: u64,
    /// Bytes read for the first-level caches, and bytes of lines from the host, by region.
    read: [u64; 5],
    loaded: [u64; 5],
    metadata_read: u64,
    metadata_write_back: u64,
    requests: u64,
    rows_opened: u64,
}

/// Bytes of a frame by class, and what they ask of the memory chips.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrafficRow {
    /// Bytes moved to and from the on-board memory: read for the first-level caches, by region of the image; `fills`, lines
    /// from the host; `metadata_read` and `metadata_write_back`. They add up to the row's `mem_bytes`.
    pub mem: BTreeMap<&'static str, u64>,
    /// Bytes loaded from the host, by region. They add up to the row's `pci_bytes`.
    pub pci: BTreeMap<&'static str, u64>,
    /// Requests to the on-board memory.
    pub requests: u64,
    /// Beats on its bus.
    pub beats: u64,
    /// Rows opened.
    pub rows_opened: u64,
    /// Requests a memory clock.
    pub requests_a_clock: f64,
}

impl TrafficWatch {
    /// For a run on this chip, of a scene with this image.
    #[must_use]
    pub fn new(image: &Image, config: &ChipConfig) -> Self {
        Self {
            starts: region_starts(image.region_bytes).expect("the image was laid out"),
            sdram: config.sdram,
            line: config.cache.geometry.line().0,
            read: [0; 5],
            loaded: [0; 5],
            metadata_read: 0,
            metadata_write_back: 0,
            requests: 0,
            rows_opened: 0,
        }
    }

    /// The row of the run that was watched.
    ///
    /// # Panics
    /// If its bytes do not add up to those of the report: then it is that of another run.
    #[must_use]
    pub fn row(&self, report: &TimingReport) -> TrafficRow {
        let pci: BTreeMap<_, _> = REGION_NAMES.into_iter().zip(self.loaded).collect();
        let fills: u64 = self.loaded.iter().sum();
        let others = [
            ("fills", fills),
            ("metadata_read", self.metadata_read),
            ("metadata_write_back", self.metadata_write_back),
        ];
        let mem: BTreeMap<_, _> = REGION_NAMES.into_iter().zip(self.read).chain(others).collect();
        assert_eq!(mem.values().sum::<u64>(), report.memory_bytes(), "Mem by class");
        assert_eq!(fills, report.pci_bytes, "PCI by class");
        let clocks = report.cycles as f64 / f64::from(self.sdram.cycles_a_clock);
        TrafficRow {
            requests: self.requests,
            beats: report.memory_bytes() / u64::from(self.sdram.beat_bytes),
            rows_opened: self.rows_opened,
            requests_a_clock: self.requests as f64 / clocks.max(1.0),
            mem,
            pci,
        }
    }

    /// The bytes of a range that each region has. What lies behind the image belongs to the last region.
    fn by_region(&self, range: Range<u64>) -> [u64; 5] {
        std::array::from_fn(|region| {
            let begin = self.starts[region];
            let end = if region == 4 { u64::MAX } else { self.starts[region + 1] };
            range.end.min(end).saturating_sub(range.start.max(begin))
        })
    }
}

impl ChipObserver for TrafficWatch {
    fn part_is_read(&mut self, _: u64, addr: HostAddr, bytes: u64, card: u64) {
        // Whole beats move. A part begins in one region, and ends there: regions begin at pages.
        let addr = u64::from(addr.0);
        let region = self.by_region(addr..addr + 1).iter().position(|&bytes| bytes > 0).unwrap_or(0);
        self.read[region] += self.sdram.moved(card, bytes);
    }

    fn line_is_written(&mut self, _: u64, load: Load) {
        let begin = u64::from(load.line.0) * self.line;
        let of_line = self.by_region(begin..begin + self.line);
        self.loaded.iter_mut().zip(of_line).for_each(|(sum, bytes)| *sum += bytes);
    }

    fn transfer(&mut self, _: u32, traffic: Traffic, _: Span, bytes: u64) {
        match traffic {
            Traffic::MetadataRead => self.metadata_read += bytes,
            Traffic::MetadataWriteBack => self.metadata_write_back += bytes,
            Traffic::L1Fill | Traffic::VmFill | Traffic::Pci => {}
        }
    }

    fn request(&mut self, _: u64, _: u64, _: u64, _: Direction) {
        self.requests += 1;
    }

    fn command(&mut self, _: u64, command: Command) {
        self.rows_opened += u64::from(matches!(command, Command::Open(..)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::Silent;
    use crate::simulate::record;
    use crate::standard;
    use crate::trace::{PacketOrder, PacketSize, TraceOptions};
    use crate::world::{World, WorldOptions};
    use saarcor_fast::chip::simulate_observed;
    use saarcor_model::time::Version;
    use saarcor_model::vm::{Bytes, Geometry};

    /// A textured level, in a memory from which lines are evicted; lines of any size.
    #[test]
    fn bytes_by_class_add_up_and_lie_where_the_units_read() {
        let world = World::open(&WorldOptions::new("pquake3-nl"), &Silent).expect("a built-in scene");
        let trace = TraceOptions { resolution: (64, 48), packet: PacketSize::Rays64, max_bounces: 1 };
        let recording = record(&world, 150, &trace, PacketOrder::default());
        for version in [Version::None, Version::A, Version::B] {
            for line in [128, 8192] {
                let mut config = standard::chip("pQuake3", version).expect("a chip");
                config.cache.geometry = Geometry::new(Bytes(64 << 10), Bytes(line), 4).expect("a geometry");
                let mut watch = TrafficWatch::new(&world.image, &config);
                let report = simulate_observed(&[], &recording.programs, &config, &mut watch).expect("a run");
                let row = watch.row(&report);
                let virtual_memory = version != Version::None;
                for region in ["nodes", "lists", "triangles", "shading", "textures"] {
                    assert!(row.mem[region] > 0, "{version:?} {region}");
                    assert_eq!(row.pci[region] > 0, virtual_memory, "{version:?} {region}");
                }
                assert_eq!(row.mem["fills"], report.pci_bytes);
                assert_eq!(row.mem["metadata_read"] > 0, version == Version::B);
                // A node is half a beat, and lines of nodes are single nodes.
                assert_eq!(row.mem["nodes"], report.l1[1].misses * 16);
                assert!(row.rows_opened > 0 && row.rows_opened <= row.beats && row.requests <= row.beats);
            }
        }
    }

    #[test]
    fn lines_across_regions_are_shared_out() {
        let mut watch = TrafficWatch {
            starts: [0, 4096, 8192, 8192, 12288, 12288],
            ..TrafficWatch::new(
                &World::open(&WorldOptions::new("pquake3-nlnt"), &Silent).expect("a scene").image,
                &standard::chip("pQuake3", Version::A).expect("a chip"),
            )
        };
        watch.line = 8192;
        assert_eq!(watch.by_region(0..8192), [4096, 4096, 0, 0, 0]);
        assert_eq!(watch.by_region(8192..16384), [0, 0, 0, 4096, 4096]);
        assert_eq!(watch.by_region(20000..20001), [0, 0, 0, 0, 1]);
    }
}
