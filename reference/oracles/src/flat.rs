//! Memory without a cache: what every unit has to see, whatever lies between.

use saarcor_model::vm::{HostAddr, Memory, Unit};

/// The host's memory, read directly. Bytes beyond its end are zero.
#[derive(Clone, Copy, Debug)]
pub struct FlatMemory<'a> {
    image: &'a [u8],
}

impl<'a> FlatMemory<'a> {
    /// The memory that holds `image` from address 0 on.
    #[must_use]
    pub fn new(image: &'a [u8]) -> Self {
        Self { image }
    }
}

impl Memory for FlatMemory<'_> {
    #[inline]
    fn read(&mut self, _unit: Unit, addr: HostAddr, bytes: &mut [u8]) {
        let start = addr.0 as usize;
        match self.image.get(start..start + bytes.len()) {
            Some(inside) => bytes.copy_from_slice(inside),
            None => read_across_the_end(self.image, start, bytes),
        }
    }
}

/// The rare case, kept out of the inlined one.
#[cold]
fn read_across_the_end(image: &[u8], start: usize, bytes: &mut [u8]) {
    for (i, byte) in bytes.iter_mut().enumerate() {
        *byte = image.get(start + i).copied().unwrap_or(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read<const N: usize>(image: &[u8], addr: u32) -> [u8; N] {
        FlatMemory::new(image).fetch(Unit::Traversal, HostAddr(addr))
    }

    #[test]
    fn bytes_are_the_images() {
        assert_eq!(read(&[1, 2, 3, 4], 1), [2, 3]);
        assert_eq!(read(&[1, 2, 3, 4], 0), [1, 2, 3, 4]);
    }

    #[test]
    fn bytes_beyond_the_end_are_zero() {
        assert_eq!(read(&[1, 2, 3, 4], 2), [3, 4, 0, 0]);
        assert_eq!(read(&[1, 2, 3, 4], 4), [0, 0]);
        assert_eq!(read(&[1, 2, 3, 4], u32::MAX), [0, 0]);
        assert_eq!(read(&[], 0), [0]);
    }
}
