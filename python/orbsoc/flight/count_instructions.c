/* A QEMU plugin: executed instructions between the marks that `orbsoc-bench --marks` sets by seeks.
 *
 *   gcc -shared -fPIC -O2 python/orbsoc/flight/count_instructions.c -o count.so
 *   qemu-aarch64 -plugin ./count.so,out=counts.txt orbsoc-bench --marks FOLDER
 *
 * Writes a line `mark NUMBER INSTRUCTIONS DIVISIONS ROOTS` for each mark, with what was executed up to it, divisions and roots of
 * doubles on aarch64 among it (a vector's two count as two), and at the end a line
 * `block ADDRESS INSTRUCTIONS EXECUTIONS` for each block of code that ran between a stage's mark and the next. The
 * prototypes are those of QEMU 7.2 (plugin interface 1), whose header Debian does not package.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef uint64_t plugin_id;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
struct qemu_info;
enum { INLINE_ADD_U64 = 0 };

extern void qemu_plugin_register_vcpu_tb_trans_cb(plugin_id, void (*)(plugin_id, struct qemu_plugin_tb *));
extern void qemu_plugin_register_vcpu_tb_exec_inline(struct qemu_plugin_tb *, int operation, void *, uint64_t);
extern size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *);
extern struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *, size_t);
extern const void *qemu_plugin_insn_data(const struct qemu_plugin_insn *);
extern size_t qemu_plugin_insn_size(const struct qemu_plugin_insn *);
extern uint64_t qemu_plugin_tb_vaddr(const struct qemu_plugin_tb *);
extern void qemu_plugin_register_vcpu_syscall_cb(
    plugin_id,
    void (*)(plugin_id, unsigned, int64_t, uint64_t, uint64_t, uint64_t, uint64_t, uint64_t, uint64_t, uint64_t, uint64_t));
extern void qemu_plugin_register_atexit_cb(plugin_id, void (*)(plugin_id, void *), void *);

__attribute__((visibility("default"))) int qemu_plugin_version = 1;

enum { LSEEK_AARCH64 = 62, LLSEEK_ARM = 140, MARK = 0x4f530000, LAST = 0x4f53ffff };

/* A translated block; one address may be translated more than once. */
struct block {
    uint64_t address, instructions, executions;
    struct block *next;
};

static struct block *blocks;
static uint64_t executed, divisions, roots;
static FILE *out;

/* Results of an instruction that is FDIV, or FSQRT, of doubles: 1 of a scalar, 2 of a vector, else 0 (Arm ARM, C7.2). */
static uint64_t results(const struct qemu_plugin_insn *insn, uint32_t scalar, uint32_t vector, uint32_t fixed)
{
    uint32_t word;
    if (qemu_plugin_insn_size(insn) != sizeof word)
        return 0;
    memcpy(&word, qemu_plugin_insn_data(insn), sizeof word);
    return (word & fixed) == scalar ? 1 : (word & fixed) == vector ? 2 : 0;
}

static void translated(plugin_id id, struct qemu_plugin_tb *tb)
{
    struct block *block = calloc(1, sizeof *block);
    if (!block)
        abort();
    (void)id;
    block->address = qemu_plugin_tb_vaddr(tb);
    block->instructions = qemu_plugin_tb_n_insns(tb);
    block->next = blocks;
    blocks = block;
    uint64_t divided = 0, rooted = 0;
    for (size_t k = 0; k < block->instructions; k++) {
        const struct qemu_plugin_insn *insn = qemu_plugin_tb_get_insn(tb, k);
        divided += results(insn, 0x1e601800, 0x6e60fc00, 0xffe0fc00);
        rooted += results(insn, 0x1e61c000, 0x6ee1f800, 0xfffffc00);
    }
    qemu_plugin_register_vcpu_tb_exec_inline(tb, INLINE_ADD_U64, &executed, block->instructions);
    qemu_plugin_register_vcpu_tb_exec_inline(tb, INLINE_ADD_U64, &divisions, divided);
    qemu_plugin_register_vcpu_tb_exec_inline(tb, INLINE_ADD_U64, &roots, rooted);
    qemu_plugin_register_vcpu_tb_exec_inline(tb, INLINE_ADD_U64, &block->executions, 1);
}

static void called(plugin_id id, unsigned cpu, int64_t number, uint64_t a1, uint64_t a2, uint64_t a3, uint64_t a4,
                   uint64_t a5, uint64_t a6, uint64_t a7, uint64_t a8)
{
    uint64_t place = number == LSEEK_AARCH64 ? a2 : number == LLSEEK_ARM ? a3 : 0;
    (void)id, (void)cpu, (void)a1, (void)a4, (void)a5, (void)a6, (void)a7, (void)a8;
    if (place >= MARK && place <= LAST)
        fprintf(out, "mark %" PRIu64 " %" PRIu64 " %" PRIu64 " %" PRIu64 "\n", place - MARK, executed, divisions, roots);
}

static void ended(plugin_id id, void *data)
{
    (void)id, (void)data;
    for (struct block *block = blocks; block; block = block->next)
        if (block->executions)
            fprintf(out, "block %#" PRIx64 " %" PRIu64 " %" PRIu64 "\n", block->address, block->instructions,
                    block->executions);
    fclose(out);
}

__attribute__((visibility("default"))) int qemu_plugin_install(plugin_id id, const struct qemu_info *info, int argc,
                                                               char **argv)
{
    (void)info;
    if (argc != 1 || strncmp(argv[0], "out=", 4) || !(out = fopen(argv[0] + 4, "w"))) {
        fprintf(stderr, "count_instructions: give out=FILE, a file that can be written\n");
        return 1;
    }
    qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
    qemu_plugin_register_vcpu_syscall_cb(id, called);
    qemu_plugin_register_atexit_cb(id, ended, NULL);
    return 0;
}
