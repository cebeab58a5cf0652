//! A list that is allocated once.

use alloc::vec::Vec;

/// A list with room for so many entries and no more: it allocates when it is made or cloned, and
/// never after that.
#[derive(Debug, PartialEq)]
pub(super) struct Bounded<T> {
    items: Vec<T>,
    room: usize,
}

impl<T> Bounded<T> {
    pub(super) fn new(room: usize) -> Self {
        Self { items: Vec::with_capacity(room), room }
    }

    /// How many entries it can hold.
    pub(super) fn room(&self) -> usize {
        self.room
    }

    /// Adds an entry; false, and none added, when there is no room for it.
    pub(super) fn push(&mut self, item: T) -> bool {
        let fits = self.items.len() < self.room;
        if fits {
            self.items.push(item);
        }
        fits
    }

    /// Adds entries as far as there is room.
    pub(super) fn extend(&mut self, items: impl Iterator<Item = T>) {
        let free = self.room - self.items.len();
        items.take(free).for_each(|item| self.items.push(item));
    }

    pub(super) fn pop(&mut self) -> Option<T> {
        self.items.pop()
    }

    pub(super) fn clear(&mut self) {
        self.items.clear();
    }

    /// Gives up the first `count` entries.
    pub(super) fn give_up(&mut self, count: usize) {
        self.items.drain(..count.min(self.items.len()));
    }

    /// Gives up all entries, one by one.
    pub(super) fn drain(&mut self) -> impl DoubleEndedIterator<Item = T> {
        self.items.drain(..)
    }
}

/// A clone has the same room: what a derived one would lose.
impl<T: Clone> Clone for Bounded<T> {
    fn clone(&self) -> Self {
        let mut clone = Self::new(self.room);
        clone.items.extend_from_slice(&self.items);
        clone
    }
}

impl<T> core::ops::Deref for Bounded<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.items
    }
}

impl<T> core::ops::DerefMut for Bounded<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.items
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_holds_what_it_has_room_for_and_so_does_its_clone() {
        let mut list = Bounded::new(3);
        assert!(list.push(1));
        let mut clone = list.clone();
        for list in [&mut list, &mut clone] {
            list.extend([2, 3, 4].into_iter());
            assert!(!list.push(5));
            assert_eq!(**list, [1, 2, 3]);
            assert!(list.items.capacity() >= 3 && list.room() == 3);
        }
        list.give_up(1);
        assert_eq!(*list, [2, 3]);
        list.give_up(9);
        assert!(list.is_empty());
    }
}
