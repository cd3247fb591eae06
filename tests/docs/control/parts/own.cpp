void change(Part* part) { part->count = 1; }
