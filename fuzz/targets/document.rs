//! A text that is read as a document reads back from its canonical form as the same document.
#![no_main]

use breccia_engine::Document;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Ok(document) = Document::parse(text) {
        let canonical = document.to_ron();
        let again = Document::parse(&canonical).expect("the canonical form of a document is read");
        assert_eq!(canonical, again.to_ron());
    }
});
