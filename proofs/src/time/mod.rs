//! Theorems of the chip in time.
