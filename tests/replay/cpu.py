"""The processor: Unicorn runs the image's instructions; exceptions, priorities and time are ours.

Time is counted in ticks of 170 MHz. An instruction costs 1.5 clocks, at the clock the image has chosen. Interrupts are
taken between basic blocks. While the main loop only polls, time jumps to the next event.
"""

from unicorn import UC_ARCH_ARM, UC_ERR_INSN_INVALID, UC_HOOK_BLOCK, UC_HOOK_INTR, UC_HOOK_MEM_INVALID, UC_HOOK_MEM_READ, UC_HOOK_MEM_WRITE
from unicorn import UC_MODE_MCLASS, UC_MODE_THUMB, Uc, UcError
from unicorn import arm_const as arm

FLASH, RAM = 0x0800_0000, 0x2000_0000
BANK_2 = FLASH + 256 * 1024
FLASH_SIZE, RAM_SIZE = 512 * 1024, 128 * 1024
SYSTEM = 0x1FFF_0000  # system memory: unique number; and where an exception returns to in this model
RETURN = SYSTEM + 0x100
HERTZ = 170_000_000
PARITY = ((RAM, RAM + 0x8000), (RAM + 0x1_8000, RAM + RAM_SIZE))
US = HERTZ // 1_000_000
PENDSV, NMI, HARD, MEM, BUS, USAGE = 14, 2, 3, 4, 5, 6
CORE = [getattr(arm, f"UC_ARM_REG_R{n}") for n in (0, 1, 2, 3, 12)]
FLOAT = [getattr(arm, f"UC_ARM_REG_S{n}") for n in range(16)]


class Hung(Exception):
    """The image did not reach what was waited for."""


class Cpu:
    def __init__(self, image, chip):
        self.chip, self.image = chip, image
        self.uc = uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
        uc.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M4)
        uc.mem_map(FLASH, FLASH_SIZE)
        uc.mem_write(FLASH, b"\xff" * FLASH_SIZE)
        uc.mem_write(FLASH, image)
        uc.mem_map(RAM, RAM_SIZE)
        uc.mem_map(SYSTEM, 0x8000)
        uc.mem_write(SYSTEM + 0x7590, bytes(range(1, 13)))  # unique device number
        uc.mem_write(RETURN, b"\x00\xbf" * 8)
        for base, size in ((0x4000_0000, 0x3_0000), (0x4800_0000, 0x2000), (0x5000_0000, 0x2000),
                           (0xE000_E000, 0x1000), (0xE004_2000, 0x1000)):
            uc.mmio_map(base, size, self._read, base, self._write, base)
        uc.hook_add(UC_HOOK_BLOCK, self._block)
        uc.hook_add(UC_HOOK_MEM_INVALID, self._invalid)
        uc.hook_add(UC_HOOK_INTR, self._intr)
        uc.hook_add(UC_HOOK_MEM_WRITE, self._flash_write, None, FLASH, FLASH + FLASH_SIZE - 1)
        uc.hook_add(UC_HOOK_MEM_READ, lambda u, k, a, n, v, d: chip.flash.look(a), None, BANK_2, FLASH + FLASH_SIZE - 1)
        self.costs = {}
        self.now, self.limit = 0, 0
        self.instructions = 0
        self.handlers = {}  # exception number -> [runs, instructions, worst]
        self.written = None  # per byte of RAM, once the parity bits are watched
        self.watch = {}  # address -> function(cpu), called when a block begins there
        self.reset()

    # --- state ---

    def reset(self):
        """Core registers as after any reset; memory keeps its content."""
        self.pending, self.active = set(), []  # exception numbers; (number, priority, instructions at entry, preempted)
        self.returned = self.attention = self.idle = False
        self.fault = None
        self.pc = self.word(FLASH + 4)
        self.uc.reg_write(arm.UC_ARM_REG_SP, self.word(FLASH))
        self.uc.reg_write(arm.UC_ARM_REG_LR, 0xFFFF_FFFF)
        self.uc.reg_write(arm.UC_ARM_REG_BASEPRI, 0)
        self.uc.reg_write(arm.UC_ARM_REG_PRIMASK, 0)

    def word(self, address):
        return int.from_bytes(self.uc.mem_read(address, 4), "little")

    def poke(self, address, value, size=4):
        self.uc.mem_write(address, value.to_bytes(size, "little"))
        self.parity_write(address, size)

    # --- parity bits of the first 32 KiB and of the CCM RAM ---

    def track_parity(self):
        """From here on, as after power-on: a byte is good once something has written it."""
        self.written, self.parity_reads, self.unwritten = bytearray(RAM_SIZE), 0, []
        for low, high in PARITY:
            self.uc.hook_add(UC_HOOK_MEM_READ, lambda u, k, a, n, v, d: self.parity_read(a, n), None, low, high - 1)
            self.uc.hook_add(UC_HOOK_MEM_WRITE, lambda u, k, a, n, v, d: self.parity_write(a, n), None, low, high - 1)

    def parity_write(self, address, size):
        if self.written is not None and RAM <= address < RAM + RAM_SIZE:
            self.written[address - RAM:address - RAM + size] = b"\x01" * size

    def parity_read(self, address, size):
        self.parity_reads += 1
        if 0 in self.written[address - RAM:address - RAM + size]:
            self.unwritten.append(f"{address:#010x} from {self.uc.reg_read(arm.UC_ARM_REG_PC):#010x}")
            self.chip.syscfg.parity_error()

    # --- time ---

    def _cost(self, address, size):
        """Instructions of a basic block: a halfword that begins 0b11101, 11110 or 11111 has a second one."""
        code, at, n = self.uc.mem_read(address, size), 0, 0
        while at + 1 < size:
            at += 4 if code[at + 1] >= 0xE8 else 2
            n += 1
        return n

    def _block(self, uc, address, size, _):
        if address == RETURN:
            self.returned = True
            return uc.emu_stop()
        key = address << 12 | size
        n = self.costs.get(key)
        if n is None:
            n = self.costs[key] = self._cost(address, size)
        if address in self.watch:
            self.watch[address](self)
        if self.attention or self.now + n * self.chip.clock_ticks_x2 // 2 >= self.limit:
            self.pc, self.stopped = address | 1, True
            return uc.emu_stop()
        self.now += n * self.chip.clock_ticks_x2 // 2
        self.instructions += n

    # --- bus ---

    def _read(self, uc, offset, size, base):
        return self.chip.read(base + offset, size)

    def _write(self, uc, offset, size, value, base):
        self.chip.write(base + offset, size, value)

    def _flash_write(self, uc, kind, address, size, value, _):
        self.chip.flash.program(address, size, value)

    def _invalid(self, uc, kind, address, size, value, _):
        self.fault = (BUS, f"access to {address:#010x}")
        return False

    def _intr(self, uc, number, _):
        # 1: undefined instruction, 3 and 4: aborts, as the emulator numbers them
        self.fault = (USAGE if number == 1 else HARD, f"exception {number}")
        uc.emu_stop()

    # --- exceptions ---

    def pend(self, number):
        self.pending.add(number)
        self.attention = True

    def _level(self):
        level = min([p for _, p, _, _ in self.active], default=256)
        if self.uc.reg_read(arm.UC_ARM_REG_PRIMASK):
            level = min(level, 0)
        base = self.uc.reg_read(arm.UC_ARM_REG_BASEPRI)
        return min(level, base) if base else level

    def _due(self):
        """The pending exception that may run now, or None."""
        ready = [(self.chip.nvic.priority(n), n) for n in self.pending if self.chip.nvic.enabled(n)]
        if not ready:
            return None
        priority, number = min(ready)
        return (priority, number) if priority < self._level() else None

    def _enter(self, priority, number):
        self.chip.met("exception_frame")
        if self.active:
            self.chip.met("priority")
        uc, self.pending = self.uc, self.pending - {number}
        sp = uc.reg_read(arm.UC_ARM_REG_SP)
        frame = (sp - 4 * 26) & ~7
        words = [uc.reg_read(r) for r in CORE] + [uc.reg_read(arm.UC_ARM_REG_LR), self.pc & ~1,
                                                  uc.reg_read(arm.UC_ARM_REG_XPSR)]
        words += [uc.reg_read(r) & 0xFFFF_FFFF for r in FLOAT] + [uc.reg_read(arm.UC_ARM_REG_FPSCR), sp]
        try:
            uc.mem_write(frame, b"".join((w & 0xFFFF_FFFF).to_bytes(4, "little") for w in words))
            self.parity_write(frame, 4 * 26)
        except UcError:
            pass  # the stack is gone: a derived fault; the pointer has moved, the frame is lost
        uc.reg_write(arm.UC_ARM_REG_SP, frame)
        uc.reg_write(arm.UC_ARM_REG_LR, RETURN | 1)
        self.active.append((number, priority, self.instructions, frame))
        self.pc = self.word(FLASH + 4 * number)

    def _leave(self):
        uc = self.uc
        number, _, entered, frame = self.active.pop()
        spent = self.instructions - entered
        if self.active:  # what interrupted a level is not its own
            below = self.active[-1]
            self.active[-1] = (*below[:2], below[2] + spent, below[3])
        runs = self.handlers.setdefault(number, [0, 0, 0])
        self.handlers[number] = [runs[0] + 1, runs[1] + spent, max(runs[2], spent)]
        data = uc.mem_read(frame, 4 * 26)
        words = [int.from_bytes(data[4 * i:4 * i + 4], "little") for i in range(26)]
        for register, word in zip(CORE, words):
            uc.reg_write(register, word)
        uc.reg_write(arm.UC_ARM_REG_LR, words[5])
        uc.reg_write(arm.UC_ARM_REG_XPSR, words[7])
        for register, word in zip(FLOAT, words[8:]):
            uc.reg_write(register, word)
        uc.reg_write(arm.UC_ARM_REG_FPSCR, words[24])
        uc.reg_write(arm.UC_ARM_REG_SP, words[25])
        self.pc = words[6] | 1

    # --- running ---

    def run(self, until, what=None, limit=None):
        """Runs to tick `until`, or until what() holds; with `what`, Hung when it does not come in time."""
        deadline = until if limit is None else self.now + limit
        while self.now < deadline:
            if what is not None and what():
                return
            self._step(deadline)
        if what is not None and not what():
            raise Hung(f"at {self.now / HERTZ:.6f} s, pc {self.pc:#010x}")

    def _step(self, deadline):
        chip = self.chip
        self.now = max(self.now, chip.run_events(self.now))
        if chip.reset_wanted:
            return chip.reset_now()
        self.attention = False
        if self.pending and (due := self._due()):
            self._enter(*due)
        self.limit = min(chip.next_event(), deadline)
        if self.idle and not self.active and not self.pending:
            self.idle = False
            self.now = max(self.now, self.limit)
            return
        self.idle = self.stopped = False
        uc = self.uc
        masked = self.pending and (uc.reg_read(arm.UC_ARM_REG_BASEPRI) or uc.reg_read(arm.UC_ARM_REG_PRIMASK))
        try:
            # the image may let a masked exception in at any instruction: look again after a few
            uc.emu_start(self.pc, 0, count=12 if masked else 0)
            if not self.stopped and not self.returned:
                self.pc = uc.reg_read(arm.UC_ARM_REG_PC) | 1
        except UcError as error:
            self.fault = self.fault or (USAGE if error.errno == UC_ERR_INSN_INVALID else BUS, str(error))
            self.pc = uc.reg_read(arm.UC_ARM_REG_PC) | 1
        if self.returned:
            self.returned = False
            self._leave()
        elif self.stopped and not self.attention:
            self.now = self.limit  # the next block reaches beyond the next event: that comes first
        if self.fault is not None:
            number, self.last_fault = self.fault
            self.fault = None
            self._enter(-1, number)
