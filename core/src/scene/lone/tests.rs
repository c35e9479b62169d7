use super::*;

#[test]
fn every_bit_becomes_its_flag() {
    for bits in 0..=0xFFu32 {
        let one_by_one = std::array::from_fn(|e| bits >> e & 1 == 1);
        assert_eq!(flags(bits), one_by_one, "{bits:08b}");
    }
}
