//! What can be wrong with a JPEG's data; each text completes "its JPEG data cannot be decoded: ".

pub(super) type Damage = &'static str;

pub(super) const CUT: Damage = "its data end before the image does";
pub(super) const LEFT: Damage = "data are left over behind the image's last block";
pub(super) const NO_CODE: Damage = "its data hold what is no code";
pub(super) const TOO_LONG: Damage = "a block of it has more than 64 coefficients";
pub(super) const TOO_BRIGHT: Damage = "a block of it is brighter or darker than a pixel can be";
pub(super) const ORDER: Damage = "a restart marker is missing, or one too many";
pub(super) const HEADER: Damage = "its header is damaged";
pub(super) const NO_TABLES: Damage = "it has no Huffman tables";
