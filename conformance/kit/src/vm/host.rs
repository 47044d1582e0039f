//! The host's memory of a session: zero but for what was written.

use saarcor_model::vm::{HostAddr, HostMemory};

const PAGE_BITS: u32 = 12;
const PAGE: usize = 1 << PAGE_BITS;
/// Pages of a part of the table.
const PART: usize = 1 << 10;

type Page = Box<[u8; PAGE]>;

/// 2³² bytes, of which only pages that were written to take space.
#[derive(Clone, Debug)]
pub struct SparseHost {
    parts: Vec<Option<Box<[Option<Page>]>>>,
}

impl Default for SparseHost {
    fn default() -> Self {
        Self { parts: vec![None; 1 << (32 - PAGE_BITS as usize - PART.ilog2() as usize)] }
    }
}

impl SparseHost {
    /// Writes bytes, as far as there are addresses.
    pub fn write(&mut self, host: u32, bytes: &[u8]) {
        for (addr, &byte) in (u64::from(host)..1 << 32).zip(bytes) {
            let page = (addr >> PAGE_BITS) as usize;
            let part = self.parts[page / PART].get_or_insert_with(|| vec![None; PART].into());
            part[page % PART].get_or_insert_with(|| Box::new([0; PAGE]))[addr as usize % PAGE] = byte;
        }
    }

    #[inline]
    fn page(&self, page: usize) -> Option<&[u8; PAGE]> {
        self.parts.get(page / PART)?.as_ref()?[page % PART].as_deref()
    }
}

impl HostMemory for SparseHost {
    #[inline]
    fn read(&self, addr: HostAddr, bytes: &mut [u8]) {
        let (mut addr, mut rest) = (u64::from(addr.0), bytes);
        while !rest.is_empty() {
            let offset = addr as usize % PAGE;
            let (now, later) = rest.split_at_mut(rest.len().min(PAGE - offset));
            match self.page((addr >> PAGE_BITS) as usize) {
                Some(page) => now.copy_from_slice(&page[offset..][..now.len()]),
                None => now.fill(0),
            }
            addr += now.len() as u64;
            rest = later;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(host: &SparseHost, addr: u32) -> [u8; 4] {
        let mut bytes = [0xff; 4];
        host.read(HostAddr(addr), &mut bytes);
        bytes
    }

    #[test]
    fn memory_is_zero_but_for_what_was_written() {
        let mut host = SparseHost::default();
        host.write(PAGE as u32 - 2, &[1, 2, 3]);
        host.write(u32::MAX, &[4, 5]);
        assert_eq!(read(&host, PAGE as u32 - 3), [0, 1, 2, 3]);
        assert_eq!(read(&host, u32::MAX - 1), [0, 4, 0, 0]);
        assert_eq!(read(&host, 0x8000_0000), [0; 4]);
    }
}
