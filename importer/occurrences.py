"""The assembly that a STEP file's text declares, beside the tree that arrived."""

from .model import BrepModel
from .step_records import StepRecords, reference, text_of

# Deeper assemblies are not followed: a file may refer in circles.
_MOST_LEVELS = 64


class Occurrences:
    """node_of: number of a PRODUCT_DEFINITION, or of a NEXT_ASSEMBLY_USAGE_OCCURRENCE, -> the first node of
    the model's tree that stands for it."""

    def __init__(self, records: StepRecords, model: BrepModel) -> None:
        self.records, self.model = records, model
        self.node_of: dict[int, int] = {}
        self._names: dict[int, str] = {}
        self._uses: dict[int, list[int]] = {}  # product definition -> what is used in it
        self._related: dict[int, int] = {}  # occurrence -> product definition
        self._words: dict[int, list[str]] = {}  # occurrence -> what it may be called
        for use in records.of_type("NEXT_ASSEMBLY_USAGE_OCCURRENCE"):
            arguments = records.parts(use)["NEXT_ASSEMBLY_USAGE_OCCURRENCE"]
            if len(arguments) >= 5:
                self._uses.setdefault(reference(arguments[3]), []).append(use)
                self._related[use] = reference(arguments[4])
                self._words[use] = [text_of(arguments[i]).strip() for i in (1, 0, -1)]
        self._children: dict[int, list[int]] = {}
        for number, node in enumerate(model.tree):
            self._children.setdefault(node.parent, []).append(number)
        self._match_roots()

    def name(self, definition: int) -> str:
        """PRODUCT_DEFINITION -> formation -> PRODUCT, whose second argument is the name, its first the id."""
        if definition not in self._names:
            self._names[definition] = self._product_name(definition)
        return self._names[definition]

    def _product_name(self, definition: int) -> str:
        record = definition
        for _ in range(2):
            arguments = next(iter(self.records.parts(record).values()), [])
            record = reference(arguments[2]) if len(arguments) > 2 else -1
        words = next(iter(self.records.parts(record).values()), [])[:2]
        return next((text.strip() for text in map(text_of, reversed(words)) if text.strip()), "")

    def _match_roots(self) -> None:
        used = set(self._related.values())
        roots = [d for d in self._definitions() if d not in used]
        nodes = self._children.get(-1, [])
        for definition, node in self._pairs(roots, nodes, {d: [self.name(d)] for d in roots}):
            self._match(definition, node, 0)

    def _definitions(self) -> list[int]:
        kinds = ("PRODUCT_DEFINITION", "PRODUCT_DEFINITION_WITH_ASSOCIATED_DOCUMENTS")
        return sorted(n for kind in kinds for n in self.records.of_type(kind))

    def _match(self, definition: int, node: int, level: int) -> None:
        if definition in self.node_of or level > _MOST_LEVELS:
            return
        self.node_of[definition] = node
        uses = self._uses.get(definition, [])
        words = {use: [*self._words[use], self.name(self._related[use])] for use in uses}
        for use, child in self._pairs(uses, self._children.get(node, []), words):
            self.node_of[use] = child
            self._match(self._related[use], child, level + 1)

    def _pairs(
        self, records: list[int], nodes: list[int], words: dict[int, list[str]]
    ) -> list[tuple[int, int]]:
        """By name, and what is left by order, where as many are left of both."""
        pairs: list[tuple[int, int]] = []
        free = list(nodes)
        left = []
        for record in records:
            node = next((n for n in free if self.model.tree[n].name in filter(None, words[record])), None)
            if node is None:
                left.append(record)
                continue
            free.remove(node)
            pairs.append((record, node))
        if len(left) == len(free):
            pairs.extend(zip(left, free, strict=True))
        return pairs
