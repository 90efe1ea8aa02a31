//! flashray, out of the library in `ours/`, which is built with default flags.
use crate::{clock, peer::*};
use libloading::Library;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ffi::{CStr, c_char};
use std::rc::{Rc, Weak};

/// The library's functions; see `ours/src/lib.rs`.
struct Lib {
    build: unsafe extern "C" fn(usize, *const Tri, *const [u32; 3], usize, *mut usize) -> *mut Handle,
    free: unsafe extern "C" fn(*mut Handle),
    closest: unsafe extern "C" fn(*const Handle, usize, *const Ray, usize, *mut Hit),
    any: unsafe extern "C" fn(*const Handle, usize, *const Ray, usize, *mut bool),
    rows: String,
    _lib: Library,
}

enum Handle {}

impl Lib {
    fn open(path: &str) -> Result<Self, libloading::Error> {
        // SAFETY: it is the library built from `ours/`, whose functions these are.
        unsafe {
            let lib = Library::new(path)?;
            let rows = lib.get::<unsafe extern "C" fn() -> *const c_char>(b"flashray_rows")?;
            let rows = CStr::from_ptr(rows()).to_string_lossy().into_owned();
            Ok(Self {
                build: *lib.get(b"flashray_build")?,
                free: *lib.get(b"flashray_free")?,
                closest: *lib.get(b"flashray_closest")?,
                any: *lib.get(b"flashray_any")?,
                rows,
                _lib: lib,
            })
        }
    }
}

/// A structure, which several rows may ask.
struct Blob {
    lib: Rc<Lib>,
    handle: *mut Handle,
    /// Of which triangles.
    of: (*const Tri, usize),
    ms: f64,
    bytes: usize,
}

impl Drop for Blob {
    fn drop(&mut self) {
        // SAFETY: nobody else has it.
        unsafe { (self.lib.free)(self.handle) };
    }
}

struct Ours {
    lib: Rc<Lib>,
    row: usize,
    name: String,
    info: String,
    extra: bool,
    /// What a row of the same structure has built.
    shared: Rc<RefCell<Weak<Blob>>>,
    blob: Option<Rc<Blob>>,
}

impl Peer for Ours {
    fn name(&self) -> String {
        self.name.clone()
    }
    fn info(&self) -> String {
        self.info.clone()
    }
    fn extra(&self) -> bool {
        self.extra
    }
    fn build(&mut self, tris: &[Tri]) -> Built {
        self.clear();
        let of = (tris.as_ptr(), tris.len());
        let known = self.shared.borrow().upgrade().filter(|blob| blob.of == of);
        let blob = known.unwrap_or_else(|| {
            let mut bytes = 0;
            // As for Embree, the index buffer is there before. The library is built without threads.
            let numbers: Vec<[u32; 3]> = (0..of.1 as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            let start = clock::thread();
            // SAFETY: the pointers are those of two slices of one length and of a number.
            let handle = unsafe { (self.lib.build)(self.row, of.0, numbers.as_ptr(), of.1, &mut bytes) };
            let ms = (clock::thread() - start) * 1e3;
            assert!(!handle.is_null(), "{} can not be built", self.name);
            Rc::new(Blob { lib: self.lib.clone(), handle, of, ms, bytes })
        });
        *self.shared.borrow_mut() = Rc::downgrade(&blob);
        let built = Built { ms: blob.ms, bytes: Some(blob.bytes) };
        self.blob = Some(blob);
        built
    }
    fn clear(&mut self) {
        self.blob = None;
    }
    fn closest(&self, rays: &[Ray], out: &mut [Hit]) {
        let blob = self.blob.as_ref().expect("built");
        assert!(out.len() >= rays.len());
        // SAFETY: there are as many places as rays, and the blob is of this row's structure.
        unsafe { (self.lib.closest)(blob.handle, self.row, rays.as_ptr(), rays.len(), out.as_mut_ptr()) }
    }
    fn any(&self, rays: &[Ray], out: &mut [bool]) {
        let blob = self.blob.as_ref().expect("built");
        assert!(out.len() >= rays.len());
        // SAFETY: as above.
        unsafe { (self.lib.any)(blob.handle, self.row, rays.as_ptr(), rays.len(), out.as_mut_ptr()) }
    }
}

/// All rows of the library at `path`; none, and a word about it, if it is not there.
pub fn peers(path: &str) -> Vec<Box<dyn Peer>> {
    let lib = match Lib::open(path) {
        Ok(lib) => Rc::new(lib),
        Err(why) => {
            eprintln!("without flashray: {why}; ./run builds it");
            return vec![];
        }
    };
    let mut shared: BTreeMap<String, Rc<RefCell<Weak<Blob>>>> = BTreeMap::new();
    let mut row = |line: &str| -> Option<Box<dyn Peer>> {
        let [row, name, structure, extra, info] = line.split('\t').collect::<Vec<_>>().try_into().ok()?;
        Some(Box::new(Ours {
            lib: lib.clone(),
            row: row.parse().ok()?,
            name: name.into(),
            info: info.into(),
            extra: extra == "1",
            shared: shared.entry(structure.into()).or_default().clone(),
            blob: None,
        }))
    };
    lib.rows.lines().filter_map(&mut row).collect()
}
